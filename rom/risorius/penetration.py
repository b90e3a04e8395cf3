"""How deep the skin of a frame is in teeth, and lips in each other: every vertex is looked at, whatever it takes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from risorius.companion import JAW, Companion
from risorius.contact_geometry import ContactGeometry, Obstacle
from risorius.jaw import FloatArray
from risorius.lip_search import LipSearch
from risorius.lip_sheets import LipSheets
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
        self._search = LipSearch(self._sheets)
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

        Past a lip's rim the nearest triangle may be turned away: a depth there is of a vertex that is outside. What is
        behind that triangle at rest, too, has tissue in between: it is beside the corner of the mouth, not in it.
        """
        numbers = self._sheets.vertices
        depths, everyone = np.zeros(len(numbers)), np.arange(len(numbers))
        near = self._search.nearest(vertices[numbers].astype(np.float64), everyone, DEEPEST)
        behind = (near.cosine < 0.0) & ~near.on_border
        behind &= self._search.in_front(self._rest[numbers], near.points, near.clearest)
        depths[near.points[behind]] = near.distances[behind]
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
