"""Skin around the mouth, and a cone in place of all other: what winding numbers of a sure look are taken of.

What a point sees of a surface is what it sees of a cone with the same border, but for whole turns, which do not change
as long as the point does not pass the cone. Its apex is far behind the mouth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
import numpy.typing as npt

from risorius.adjacency import triangles_across
from risorius.winding_number import place_corners

BEHIND = 0.2  # metres


@dataclass(frozen=True)
class SkinAround:
    """triangles (k, 3) around the mouth, edges (e, 2) where other skin ends, as they go round it, and the apex (3,)."""

    triangles: npt.NDArray[np.int32]
    edges: npt.NDArray[np.int32]
    apex: npt.NDArray[np.float32]

    @classmethod
    def of(
        cls, vertices: npt.NDArray[np.integer], rest: npt.NDArray[np.float32], skin: npt.NDArray[np.int32]
    ) -> SkinAround:
        """That of the triangles between some vertices, of all skin (m, 3) and its vertices at rest (n, 3)."""
        near = np.asarray(np.isin(skin, vertices).all(axis=1))
        triangles, other, across = skin[near], skin[~near], triangles_across(skin)[~near]
        beside = (across >= 0) & near[across]
        number, corner = np.nonzero(beside | (across < 0))
        edges = np.column_stack([other[number, corner], other[number, (corner + 1) % 3]])
        corners = rest[triangles].astype(np.float64)
        outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(axis=0)
        middle = corners.mean(axis=(0, 1)) if len(corners) else np.zeros(3)
        apex = middle - BEHIND * outward / max(float(np.linalg.norm(outward)), np.finfo(float).tiny)
        return cls(np.ascontiguousarray(triangles), edges.astype(np.int32), apex.astype(np.float32))

    @property
    def size(self) -> int:
        """Number of triangles with those of the cone."""
        return len(self.triangles) + len(self.edges)


@numba.njit(cache=True, error_model="numpy")
def place_skin(x, triangles, edges, apex, corners):  # type: ignore[no-untyped-def]
    """Write the corners (9, k + e) of triangles (k, 3) of vertices x (n, 3), and of the cone from edges (e, 2)."""
    place_corners(x, triangles, corners)
    for e in range(len(edges)):
        i, j, t = edges[e, 0], edges[e, 1], len(triangles) + e
        for k in range(3):
            corners[k, t], corners[3 + k, t], corners[6 + k, t] = x[i, k], x[j, k], apex[k]
