"""The meshcat scene around the face, as commands in meshcat's own protocol: mesh, camera, lights, background.

Meshcat's world has z up and its camera looks along -x; the face comes in with y up and z out of the face, and stands
with the middle of its bounding box at meshcat's origin, which is what meshcat's camera turns about.
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

FACE_PATH = ("meshcat", "face")
FIELD_OF_VIEW = 22.0  # degrees, vertical: a portrait lens
AZIMUTH, ELEVATION = math.radians(28.0), math.radians(4.0)  # three-quarter view, from the person's right

_CAMERA = ("Cameras", "default", "rotated")
_TO_MESHCAT = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # (x, y, z) of the model -> (z, x, y)
_SKIN, _SKIN_SHINE = 0xD9A58A, 0x2A211D
# Positions in metres in meshcat's frame: x towards the viewer, y to the person's left, z up.
_LIGHTS: tuple[tuple[str, tuple[float, float, float], float], ...] = (
    ("PointLightNegativeX", (1.2, -1.0, 0.9), 0.62),  # key: above, on the viewer's left
    ("PointLightPositiveX", (1.0, 1.4, 0.1), 0.20),  # fill
    ("FillLight", (-1.2, 1.0, 1.0), 0.30),  # rim, from behind
)
_AMBIENT = 0.36


def stage_commands(vertices: npt.NDArray[np.float32], triangles: npt.NDArray[np.int32]) -> list[bytes]:
    """Return packed meshcat commands that set up the scene for a face; the face itself comes last.

    vertices: (n, 3), metres, model frame; triangles: (m, 3). The page places the camera's distance.
    """
    centre = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
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
        SetObject(
            TriangularMeshGeometry(vertices, triangles),
            MeshPhongMaterial(color=_SKIN, specular=_SKIN_SHINE, shininess=16),
            Path(FACE_PATH),
        ),
    ]
    return [umsgpack.packb(command.lower()) for command in commands]


def _property(path: tuple[str, ...], key: str, value: object) -> Any:
    return SetProperty(key, value, Path(path))
