"""A picture of a face, drawn off screen: portrait lens, three soft lights, no axes."""

from __future__ import annotations

import ctypes.util
import itertools
import math
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from risorius import storage
from risorius.companion import Companion
from risorius.errors import Error, InputError, MissingExtraError
from risorius.surface import NO_COLOURS, Colours

VIEWS = {"front": (0.0, 0.0), "three-quarter": (-28.0, 4.0), "side": (-90.0, 0.0)}
"""Azimuth and elevation of the camera, degrees; a negative azimuth is on the person's right."""

SIZE_LIMITS = (16, 8192)  # pixels; the larger is what software drawing manages

_FIELD_OF_VIEW = 22.0  # degrees, vertical
_MARGIN = 0.88  # share of the picture that the face fills
_BACKGROUND = (0.76, 0.78, 0.80), (0.93, 0.94, 0.95)  # bottom, top
_SKIN = (0.89, 0.69, 0.58)
_SKIN_SHINE = {"smooth_shading": True, "ambient": 0.22, "diffuse": 0.8, "specular": 0.12, "specular_power": 14}
# Lights turn with the camera: direction in its frame (right, up, towards the viewer) and intensity.
_LIGHTS = (((-0.9, 0.8, 1.0), 0.95), ((1.2, 0.0, 0.9), 0.35), ((0.6, 0.8, -1.0), 0.5))
_WINDOW_CHOICE = "VTK_DEFAULT_OPENGL_WINDOW"


def draw_face(
    vertices: npt.NDArray[np.floating],
    triangles: npt.NDArray[np.integer],
    *,
    view: str = "three-quarter",
    size: tuple[int, int] = (900, 900),
    keep_in_view: npt.NDArray[np.floating] | None = None,
    colours: Colours = NO_COLOURS,
    companions: Sequence[Companion] = (),
) -> npt.NDArray[np.uint8]:
    """Return a picture (height, width, 3) of a face.

    vertices: (n, 3) in the model frame (x to the person's left, y up, z out of the face), metres. triangles: (m, 3),
    counter-clockwise seen from outside. view: one of VIEWS. size: (width, height), pixels. keep_in_view: further points
    (k, 3) that the picture has to have room for, so that several pictures share one camera. colours: of the vertices,
    or NO_COLOURS. companions: drawn where their points are, whether there is room for them or not.

    Raises InputError for a bad view, size or mesh, MissingExtraError without pyvista, Error where nothing can draw.
    """
    _check(vertices, triangles, view, size)
    room = vertices if keep_in_view is None else np.concatenate([vertices, keep_in_view])
    with _studio(size) as plotter:
        return _picture(plotter, [_solid(vertices, triangles, colours), *companions], room, VIEWS[view])


def draw_faces(
    faces: Sequence[npt.NDArray[np.floating]],
    triangles: npt.NDArray[np.integer],
    *,
    views: Sequence[str],
    size: tuple[int, int],
    colours: Colours = NO_COLOURS,
    companions: Sequence[Sequence[Companion]] = (),
) -> list[list[npt.NDArray[np.uint8]]]:
    """Return a picture (height, width, 3) of each face from each view; all from one view share the camera.

    faces: vertices (n, 3) each. companions: of each face, or of none. Otherwise as `draw_face`, and raises the same.
    """
    for vertices, view in itertools.product(faces, views):
        _check(vertices, triangles, view, size)
    room = np.concatenate(faces)
    beside = companions or [()] * len(faces)
    solids = [[_solid(face, triangles, colours), *others] for face, others in zip(faces, beside, strict=True)]
    with _studio(size) as plotter:
        return [[_picture(plotter, shown, room, VIEWS[view]) for view in views] for shown in solids]


def _solid(vertices: npt.NDArray[np.floating], triangles: npt.NDArray[np.integer], colours: Colours) -> Companion:
    return Companion(np.asarray(vertices, dtype=np.float64), np.asarray(triangles, dtype=np.int64), colours)


def save_png(path: Path, picture: npt.NDArray[np.uint8]) -> None:
    """Write a picture (height, width, 3) as PNG; it appears under its name only when complete."""
    try:
        from PIL import Image
    except ModuleNotFoundError as error:
        raise MissingExtraError("writing a picture", "view", "pillow") from error
    with storage.replaced_when_complete(path) as partial:
        Image.fromarray(picture).save(partial, format="PNG")


def _check(
    vertices: npt.NDArray[np.floating], triangles: npt.NDArray[np.integer], view: str, size: tuple[int, int]
) -> None:
    if view not in VIEWS:
        raise InputError(f"view {view!r} is not known; choose from: {', '.join(VIEWS)}")
    low, high = SIZE_LIMITS
    if not all(low <= pixels <= high for pixels in size):
        raise InputError(f"size {size[0]}x{size[1]}: both sides must be {low} to {high} pixels")
    if vertices.ndim != 2 or vertices.shape[1] != 3 or triangles.ndim != 2 or triangles.shape[1] != 3:
        raise InputError(f"mesh: vertices {vertices.shape} and triangles {triangles.shape}; give (n, 3) and (m, 3)")
    if not np.isfinite(vertices).all():
        raise InputError("mesh: some vertices are not finite; the frame they come from cannot be drawn")
    if not len(triangles) or triangles.min() < 0 or triangles.max() >= len(vertices):
        raise InputError(f"mesh: triangles must number vertices from 0 to {len(vertices) - 1}, and there must be some")


@contextmanager
def _studio(size: tuple[int, int]) -> Iterator[Any]:
    """Yield a plotter with background and lights, and close it."""
    try:
        import pyvista
    except ModuleNotFoundError as error:
        raise MissingExtraError("drawing a picture", "view", str(error.name)) from error

    with _window_without_display():
        plotter = pyvista.Plotter(off_screen=True, window_size=list(size), lighting="none")
        try:
            _require_opengl(plotter)
            plotter.set_background(_BACKGROUND[0], top=_BACKGROUND[1])
            for direction, intensity in _LIGHTS:
                plotter.add_light(_light(pyvista, direction, intensity))
            plotter.enable_anti_aliasing("ssaa")
            yield plotter
        finally:
            plotter.close()


def _picture(
    plotter: Any,
    solids: Sequence[Companion],
    room: npt.NDArray[np.floating],
    angles: tuple[float, float],
) -> npt.NDArray[np.uint8]:
    """Draw a face and its companions in place of the last ones."""
    from pyvista import PolyData

    for number, solid in enumerate(solids):
        mesh = PolyData.from_regular_faces(solid.points, solid.triangles)
        shown = mesh.compute_normals(cell_normals=False, split_vertices=False, consistent_normals=False)
        paint: dict[str, Any] = {"color": _SKIN}
        if len(solid.colours):
            shown["colours"] = solid.colours
            paint = {"scalars": "colours", "rgb": True}
        plotter.add_mesh(shown, name=f"solid {number}", reset_camera=False, render=False, **paint, **_SKIN_SHINE)
    width, height = plotter.window_size
    _place_camera(plotter.camera, room, angles, width / height)
    plotter.render()
    return np.ascontiguousarray(plotter.screenshot(return_img=True)[..., :3])


@contextmanager
def _window_without_display() -> Iterator[None]:
    """Let VTK begin with EGL where there is no X server, instead of complaining about that and then taking EGL."""
    if sys.platform != "linux" or os.environ.get("DISPLAY") or _WINDOW_CHOICE in os.environ:
        yield
        return
    os.environ[_WINDOW_CHOICE] = "vtkEGLRenderWindow"
    try:
        yield
    finally:
        del os.environ[_WINDOW_CHOICE]


def _require_opengl(plotter: Any) -> None:
    """Raise Error where VTK found neither X, EGL nor OSMesa: it would crash the process at the first drawing."""
    last_resort = plotter.render_window.GetClassName() == "vtkOSOpenGLRenderWindow"
    if last_resort and ctypes.util.find_library("OSMesa") is None:
        raise Error(
            "no OpenGL here to draw with: neither an X server, EGL nor OSMesa; "
            "install Mesa's EGL (on Debian and Ubuntu: apt install libegl1 libgl1-mesa-dri)"
        )


def _light(pyvista: Any, direction: tuple[float, float, float], intensity: float) -> Any:
    light = pyvista.Light(light_type="camera light", intensity=intensity)
    light.position = direction
    light.focal_point = (0.0, 0.0, 0.0)
    return light


def _place_camera(camera: Any, points: npt.NDArray[np.floating], angles: tuple[float, float], aspect: float) -> None:
    """Put the camera as near as it can be with all points (n, 3) in the picture."""
    azimuth, elevation = np.deg2rad(angles)
    towards = np.array(
        [math.sin(azimuth) * math.cos(elevation), math.sin(elevation), math.cos(azimuth) * math.cos(elevation)]
    )
    right = np.array([math.cos(azimuth), 0.0, -math.sin(azimuth)])
    axes = np.stack([right, np.cross(towards, right), towards])
    seen = points @ axes.T
    centre = 0.5 * (seen.min(axis=0) + seen.max(axis=0))
    tangent = _MARGIN * math.tan(math.radians(_FIELD_OF_VIEW / 2.0))
    reach = np.abs(seen[:, :2] - centre[:2]) / (tangent * np.array([aspect, 1.0]))
    distance = float((reach.max(axis=1) + seen[:, 2] - centre[2]).max())
    camera.focal_point = tuple(axes.T @ centre)
    camera.position = tuple(axes.T @ centre + distance * axes[2])
    camera.up = tuple(axes[1])
    camera.view_angle = _FIELD_OF_VIEW
    camera.clipping_range = (0.01 * distance, 10.0 * distance)
