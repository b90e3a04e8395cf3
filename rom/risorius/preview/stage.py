"""The meshcat scene around the face, as commands in meshcat's own protocol: mesh, camera, lights, background.

Meshcat's world has z up and its camera looks along -x; the face comes in with y up and z out of the face, and stands
with the middle of its bounding box at meshcat's origin, which is what meshcat's camera turns about. Companions are its
children in meshcat's tree, by name.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import umsgpack
from meshcat.commands import SetObject, SetProperty, SetTransform
from meshcat.geometry import MeshPhongMaterial, PerspectiveCamera, TriangularMeshGeometry
from meshcat.path import Path

from risorius.model import ReducedModel
from risorius.surface import Colours

FACE_PATH = ("meshcat", "face")
FIELD_OF_VIEW = 22.0  # degrees, vertical: a portrait lens
AZIMUTH, ELEVATION = math.radians(28.0), math.radians(4.0)  # three-quarter view, from the person's right

_CAMERA = ("Cameras", "default", "rotated")
_TO_MESHCAT = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # (x, y, z) of the model -> (z, x, y)
_SKIN, _SKIN_SHINE = 0xD9A58A, 0x2A211D
_WHITE = 0xFFFFFF
# Positions in metres in meshcat's frame: x towards the viewer, y to the person's left, z up.
_LIGHTS: tuple[tuple[str, tuple[float, float, float], float], ...] = (
    ("PointLightNegativeX", (1.2, -1.0, 0.9), 0.62),  # key: above, on the viewer's left
    ("PointLightPositiveX", (1.0, 1.4, 0.1), 0.20),  # fill
    ("FillLight", (-1.2, 1.0, 1.0), 0.30),  # rim, from behind
)
_AMBIENT = 0.36


def stage_commands(model: ReducedModel) -> list[bytes]:
    """Return packed meshcat commands that set up the scene for a face; the face itself comes last.

    The page places the camera's distance, moves the face and poses the companions.
    """
    rest = model.rest_vertices
    centre = 0.5 * (rest.min(axis=0) + rest.max(axis=0))
    pose = np.eye(4)
    pose[:3, :3] = _TO_MESHCAT
    pose[:3, 3] = -_TO_MESHCAT @ centre
    direction = [
        math.cos(ELEVATION) * math.cos(AZIMUTH),
        math.sin(ELEVATION),
        math.cos(ELEVATION) * math.sin(AZIMUTH),
    ]
    commands: list[Any] = [
        _property(("Grid",), "visible", False),
        _property(("Axes",), "visible", False),
        _property(("Background",), "top_color", [0.93, 0.94, 0.95]),
        _property(("Background",), "bottom_color", [0.76, 0.78, 0.80]),
        _property(("Lights", "AmbientLight", "<object>"), "intensity", _AMBIENT),
    ]
    for name, position, intensity in _LIGHTS:
        commands.append(_property(("Lights", name, "<object>"), "position", list(position)))
        commands.append(_property(("Lights", name, "<object>"), "intensity", intensity))
    commands += [
        SetObject(PerspectiveCamera(fov=FIELD_OF_VIEW, near=0.01, far=20.0), path=Path(_CAMERA)),
        _property((*_CAMERA, "<object>"), "position", direction),
        SetTransform(pose, Path(FACE_PATH)),
    ]
    for name, thing in model.companions.items():
        commands.append(_mesh((*FACE_PATH, name), thing.points, thing.triangles, thing.colours))
    commands.append(_mesh(FACE_PATH, rest, model.triangles, model.colours))
    return [umsgpack.packb(command.lower()) for command in commands]


def _mesh(
    path: tuple[str, ...], points: npt.NDArray[np.floating], triangles: npt.NDArray[np.integer], colours: Colours
) -> Any:
    """Return the command for a mesh; without colours it is all skin.

    This version of three.js draws colours as they are given, those of a vertex as those of a material.
    """
    of_vertices = colours / np.float32(255.0) if len(colours) else None
    return SetObject(
        TriangularMeshGeometry(points, triangles, of_vertices),
        MeshPhongMaterial(
            color=_SKIN if of_vertices is None else _WHITE,
            specular=_SKIN_SHINE,
            shininess=16,
            vertexColors=of_vertices is not None,
        ),
        Path(path),
    )


def _property(path: tuple[str, ...], key: str, value: object) -> Any:
    return SetProperty(key, value, Path(path))
