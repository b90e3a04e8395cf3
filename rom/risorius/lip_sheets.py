"""The two lips as sheets of triangles that can meet: what lies around the seam, told apart by the side they are on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from risorius.adjacency import triangles_across
from risorius.geodesics import distances_from, edge_lengths
from risorius.jaw import FloatArray

IntArray = npt.NDArray[np.int32]
WIDTH = 10e-3  # of a sheet on either side of the seam, metres along the surface


@dataclass(frozen=True)
class LipSheets:
    """Sheets 0 (of the upper lip) and 1. vertices (s,) of the surface that lie in one, sheet (s,) which.

    triangles (t, 3), vertex numbers of the surface; sheet_of (t,); across (t, 3): triangle of the same sheet beyond the
    edge from corner k to the next, -1 at the border. facing (s,): a triangle of the other sheet, the nearest at rest.
    """

    vertices: IntArray
    sheet: IntArray
    triangles: IntArray
    sheet_of: IntArray
    across: IntArray
    facing: IntArray

    @classmethod
    def of(cls, seam: npt.NDArray[np.int64], rest: npt.NDArray[np.floating], triangles: IntArray) -> LipSheets:
        """Sheets around a seam (k, 2), pairs of a vertex and the triangle it faces, of a surface at rest, y up.

        Without vertices and triangles where nothing faces anything from above, or from below.
        """
        points = rest.astype(np.float64)
        centres = points[triangles].mean(axis=1)
        lower = points[seam[:, 0], 1] < centres[seam[:, 1], 1]
        if lower.all() or not lower.any():
            seam, lower = seam[:0], lower[:0]
        label = _nearest_side(points, triangles, seam[~lower, 0], seam[lower, 0])
        of_corners = label[triangles]
        inside = np.flatnonzero((of_corners[:, 0] >= 0) & (of_corners == of_corners[:, :1]).all(axis=1))
        if len(np.unique(of_corners[inside])) < 2:
            inside = inside[:0]
        kept, sheet_of = triangles[inside].astype(np.int32), of_corners[inside, 0].astype(np.int32)
        vertices = np.unique(kept).astype(np.int32)
        sheet = label[vertices].astype(np.int32)
        facing = np.zeros(len(vertices), dtype=np.int32)
        for side in np.unique(sheet):
            other, mine = np.flatnonzero(sheet_of != side), np.flatnonzero(sheet == side)
            facing[mine] = other[_nearest(points[vertices[mine]], centres[inside[other]])]
        return cls(vertices, sheet, kept, sheet_of, triangles_across(kept), facing)


def on_border(triangles: IntArray, across: IntArray, count: int) -> npt.NDArray[np.bool_]:
    """(count,) vertices on the border of triangles (t, 3), across (t, 3) as in `LipSheets`."""
    flags = np.zeros(count, dtype=bool)
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)
    flags[ends[across < 0]] = True
    return flags


def _nearest_side(points: FloatArray, triangles: IntArray, upper: IntArray, lower: IntArray) -> IntArray:
    """(n,) 0 or 1 by whichever set of vertices is nearer along the surface, -1 where neither is within WIDTH."""
    graph = edge_lengths(points, triangles)
    away = np.stack([distances_from(graph, side, WIDTH) for side in (upper, lower)])
    label: IntArray = np.where(away.min(axis=0) < np.inf, away.argmin(axis=0), -1).astype(np.int32)
    return label


def _nearest(points: FloatArray, centres: FloatArray) -> IntArray:
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(centres).query(points)[1], dtype=np.int32)
