"""How deep the skin of a frame is in teeth, and lips in each other: every vertex is looked at, whatever it takes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numba
import numpy as np
import numpy.typing as npt

from risorius.closest_point import closest_point
from risorius.companion import JAW, Companion
from risorius.contact_geometry import ContactGeometry, Obstacle
from risorius.jaw import FloatArray
from risorius.lip_sheets import LipSheets, on_border
from risorius.normals import vertex_normals
from risorius.poses import Poses
from risorius.winding_number import winding_number

DEEPEST = 4e-3  # metres; what is farther behind a lip is not in it
OUT_OF_ITSELF = 0.02e-3  # metres that a point is moved out of its own skin, to be told whether it is in other tissue
# By which the winding number of the skin grows where a point gets into tissue. It is one, less where skin ends nearby.
WOUND = 0.25


@dataclass(frozen=True)
class Penetration:
    """Depths in metres, zero where nothing is in anything: of skin in teeth, and of lips in each other."""

    teeth: float
    lips: float


class PenetrationMeasure:
    """Measures frames of a surface with vertices at rest (n, 3) and triangles (m, 3), in the frame of the head."""

    def __init__(
        self,
        geometry: ContactGeometry,
        poses: Poses,
        rest: npt.NDArray[np.floating],
        triangles: npt.NDArray[np.int32],
    ) -> None:
        self._obstacles, self._poses = geometry.obstacles, poses
        self._at_rest = {
            name: np.minimum(obstacle.distance(rest), 0.0) for name, obstacle in geometry.obstacles.items()
        }
        self._sheets = LipSheets.of(geometry.seam, rest, triangles)
        self._in_border = on_border(self._sheets.triangles, self._sheets.across, len(rest))
        self._rest, self._triangles = np.asarray(rest, dtype=np.float64), triangles

    @property
    def lip_vertices(self) -> npt.NDArray[np.int32]:
        """Numbers (s,) of the vertices that `depths_in_lips` looks at."""
        return self._sheets.vertices

    def __call__(self, vertices: npt.NDArray[np.floating], coordinates: npt.NDArray[np.floating]) -> Penetration:
        """Depths of vertices (n, 3) and coordinates (r,) of a frame; what is in a tooth at rest counts from there."""
        depth = self.depths_in_obstacles(vertices, coordinates)
        return Penetration(float(depth.max(initial=0.0)), self._deepest_in_lips(vertices))

    def depths_in_obstacles(
        self, vertices: npt.NDArray[np.floating], coordinates: npt.NDArray[np.floating], around: float = 0.0
    ) -> FloatArray:
        """Depth (o, n) of every vertex in each obstacle or in what is `around` metres about it; negative outside."""
        depths = np.empty((len(self._obstacles), len(vertices)))
        for depth, (name, obstacle) in zip(depths, self._obstacles.items(), strict=True):
            at_rest = _seen_from(obstacle, self._poses, vertices.astype(np.float64), coordinates)
            depth[:] = around + self._at_rest[name] - obstacle.distance(at_rest)
        return depths

    def depths_in_lips(self, vertices: npt.NDArray[np.floating]) -> FloatArray:
        """Depth (s,) of every vertex of the lips in the other lip, metres, as its nearest triangles have it.

        Past a lip's rim the nearest triangle may be turned away: a depth there is of a vertex that is outside.
        """
        sheets = self._sheets
        depths = np.zeros(len(sheets.vertices))
        _depths_in_sheets(
            vertices.astype(np.float64), self._rest, sheets.vertices, sheets.sheet, sheets.triangles, sheets.sheet_of,
            sheets.across, self._in_border, depths,
        )  # fmt: skip
        return depths

    def _deepest_in_lips(self, vertices: npt.NDArray[np.floating]) -> float:
        """Largest depth of a vertex around which the skin has closed since it was at rest."""
        depths = self.depths_in_lips(vertices)
        deepest = np.argsort(-depths)[: np.count_nonzero(depths)]
        places, numbers = vertices.astype(np.float64), self._sheets.vertices[deepest]
        for depth, now, before in zip(
            depths[deepest], self._windings(places, numbers), self._windings(self._rest, numbers), strict=True
        ):
            if now - before > WOUND:
                return float(depth)
        return 0.0

    def _windings(self, places: FloatArray, numbers: npt.NDArray[np.int32]) -> Iterator[float]:
        """Winding numbers beside some of the vertices, at places (n, 3), where these are seen from outside."""
        normals = vertex_normals(places.astype(np.float32), self._triangles) if len(numbers) else places
        for number in numbers:
            yield winding_number(places[number] + OUT_OF_ITSELF * normals[number], places, self._triangles)


def _seen_from(
    obstacle: Obstacle, poses: Poses, points: FloatArray, coordinates: npt.NDArray[np.floating]
) -> FloatArray:
    """Where points (n, 3) are as seen from an obstacle at rest."""
    if obstacle.moves_with != JAW:
        return points
    frame = Companion(np.vstack([np.zeros(3), np.eye(3)]), np.zeros((0, 3), np.int64), np.zeros((4, 3), np.uint8), JAW)
    origin, *axes = frame.posed(poses, coordinates)
    return (points - origin) @ (np.array(axes) - origin).T


@numba.njit(cache=True, error_model="numpy")
def _depths_in_sheets(x, rest, vertices, sheet, triangles, sheet_of, across, border, depths):  # type: ignore[no-untyped-def]
    """Distance of vertices that are behind the nearest point of the other sheet, unless that is on its border.

    What is behind that triangle at rest, too, has tissue in between: beside the corner of the mouth, not in it.
    """
    w, best = np.empty(3), np.empty(3)
    centres, radii = np.zeros((len(triangles), 3)), np.zeros(len(triangles))
    for t in range(len(triangles)):
        for k in range(3):
            centres[t] += x[triangles[t, k]] / 3.0
        for k in range(3):
            radii[t] = max(radii[t], math.sqrt(np.sum((x[triangles[t, k]] - centres[t]) ** 2)))
    for number in range(len(vertices)):
        p = vertices[number]
        nearest, cosine, found = DEEPEST * DEEPEST, 0.0, -1
        for t in range(len(triangles)):
            if sheet_of[t] == sheet[number]:
                continue
            reach, square = math.sqrt(nearest) + radii[t] + 1e-9, 0.0
            for i in range(3):
                square += (x[p, i] - centres[t, i]) ** 2
            if square > reach * reach:
                continue
            a, b, c = x[triangles[t, 0]], x[triangles[t, 1]], x[triangles[t, 2]]
            square, w[0], w[1], w[2] = closest_point(
                x[p, 0], x[p, 1], x[p, 2], a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]
            )
            if square > nearest * (1.0 + 1e-9) + 1e-18:
                continue
            n = np.cross(b - a, c - a)
            r = x[p] - (w[0] * a + w[1] * b + w[2] * c)
            turned = n @ r / max(math.sqrt((n @ n) * square), 1e-30)
            if square < nearest * (1.0 - 1e-9) - 1e-18 or abs(turned) > abs(cosine):
                cosine, found, best[:] = turned, t, w
                nearest = min(nearest, square)
        if found < 0 or cosine >= 0.0 or _on_border(triangles[found], across[found], border, best):
            continue
        a, b, c = rest[triangles[found, 0]], rest[triangles[found, 1]], rest[triangles[found, 2]]
        if np.cross(b - a, c - a) @ (rest[p] - a) >= 0.0:
            depths[number] = math.sqrt(nearest)


@numba.njit(cache=True, error_model="numpy")
def _on_border(corners, across, border, w):  # type: ignore[no-untyped-def]
    for k in range(3):
        if w[k] == 1.0 and border[corners[k]]:
            return True
        if w[(k + 2) % 3] == 0.0 and across[k] < 0:
            return True
    return False
