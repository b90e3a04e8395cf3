"""Which place of the other of two sheets of triangles a point is nearest to, and on which side of it the point is.

Triangles are sorted into a uniform grid by their middles (Ericson 2005, Real-Time Collision Detection, 7.1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np
import numpy.typing as npt

from risorius.adjacency import vertex_fans
from risorius.closest_point import closest_point
from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius.lip_sheets import IntArray, LipSheets, on_border

CELL, MOST_CELLS = 2e-3, 64  # metres, larger where there would be more of them along an axis

Numbers = npt.NDArray[np.int64]
Flags = npt.NDArray[np.bool_]
_compiled = numba.njit(cache=True, error_model="numpy")


@dataclass(frozen=True)
class Nearest:
    """What points (c,) are nearest to: triangles (c,) of the other sheet, at distances (c,), metres.

    on_border (c,): whether the nearest place is on the border of its sheet; at_rim (c,): whether it is there or on what
    lies between vertices of the border alone. Triangles that meet at the place may be turned differently: clearest (c,)
    is the one whose normal makes an angle with the way to the point that is the farthest from a right one, cosine (c,)
    that angle's, greatest (c,) the greatest of all; negative ones are of points behind.
    """

    points: Numbers
    triangles: Numbers
    distances: FloatArray
    on_border: Flags
    at_rim: Flags
    clearest: Numbers
    cosine: FloatArray
    greatest: FloatArray


class LipSearch:
    """Finds what is nearest to the vertices of two sheets, whose places x (s, 3) are in the order of these.

    corners (t, 3): of the triangles, by this order.
    """

    def __init__(self, sheets: LipSheets) -> None:
        count = len(sheets.vertices)
        self.corners: IntArray = np.searchsorted(sheets.vertices, sheets.triangles).astype(np.int32)
        self._sheets = (self.corners, sheets.sheet_of, sheets.sheet, sheets.facing)
        self._around = (self.corners, sheets.across, *vertex_fans(self.corners, count))
        self._edge_ends, self._border = sheets.across < 0, on_border(self.corners, sheets.across, count)

    def nearest(self, x: FloatArray, points: Numbers, within: float) -> Nearest:
        """Nearest places to some points (p,); those with nothing of the other sheet within so many metres are left out.

        Raises InputError for places that are no numbers.
        """
        if not np.isfinite(x).all():
            point = int(np.flatnonzero(~np.isfinite(x).all(axis=1))[0])
            raise InputError(f"vertex {point} of the lips is at {x[point]}; give places that are finite numbers")
        triangles, weights, distances = _nearest_places(x, points, within, *self._sheets)
        found = np.flatnonzero(triangles >= 0)
        points, triangles, weights = points[found], triangles[found], weights[found]
        border, across_corner = self._border[self.corners[triangles]], np.roll(weights, 1, axis=1)
        return Nearest(
            points,
            triangles,
            distances[found],
            ((border & (weights == 1.0)) | (self._edge_ends[triangles] & (across_corner == 0.0))).any(axis=1),
            (border | (weights == 0.0)).all(axis=1),
            *_sides(x, points, triangles, weights, *self._around),
        )

    def in_front(self, x: FloatArray, points: Numbers, triangles: Numbers) -> Flags:
        """Which of points (c,) are in or in front of the planes of triangles (c,), one each."""
        return _in_front(x, points, triangles, self.corners)


@_compiled
def _nearest_places(x, points, within, corners, sheet_of, sheet, facing):  # type: ignore[no-untyped-def]
    """Triangles (p,) of the other sheet, -1 where none is within so many metres, weights (p, 3) and distances (p,)."""
    near, weights, distances = np.empty(len(points), np.int64), np.empty((len(points), 3)), np.empty(len(points))
    if not len(points):
        return near, weights, distances
    grid = _grid(x, corners)
    for number in range(len(points)):
        p, w = points[number], weights[number]
        near[number], distances[number] = _nearest(x, p, corners, sheet_of, sheet[p], grid, facing[p], within, w)
    return near, weights, distances


@_compiled
def _grid(x, corners):  # type: ignore[no-untyped-def]
    """Middles and radii of triangles; origin of the cells, their size, how many along each axis, and what is in each.

    That is (starts, listed): triangles by cell, and where those of each begin.
    """
    centres, radii = _middles(x, corners)
    low, high = centres[0].copy(), centres[0].copy()
    for t in range(len(centres)):
        for i in range(3):
            low[i], high[i] = min(low[i], centres[t, i]), max(high[i], centres[t, i])
    size, counts = np.empty(3), np.ones(3, np.int64)
    for i in range(3):
        size[i] = max(CELL, (high[i] - low[i]) / MOST_CELLS)
        counts[i] = int((high[i] - low[i]) / size[i]) + 1
    starts = np.zeros(counts[0] * counts[1] * counts[2] + 1, np.int64)
    cells = np.zeros(len(centres), np.int64)
    for t in range(len(centres)):
        for i in range(3):
            cells[t] = cells[t] * counts[i] + int((centres[t, i] - low[i]) / size[i])
        starts[cells[t] + 1] += 1
    starts = np.cumsum(starts)
    listed, place = np.empty(len(centres), np.int64), starts.copy()
    for t in range(len(centres)):
        listed[place[cells[t]]] = t
        place[cells[t]] += 1
    return centres, radii, radii.max(), low, size, counts, starts, listed


@_compiled
def _middles(x, corners):  # type: ignore[no-untyped-def]
    """Middles (t, 3) of triangles, and the distances (t,) of their farthest corners."""
    centres, radii = np.empty((len(corners), 3)), np.empty(len(corners))
    for t in range(len(corners)):
        for i in range(3):
            centres[t, i] = (x[corners[t, 0], i] + x[corners[t, 1], i] + x[corners[t, 2], i]) / 3.0
        square = 0.0
        for k in range(3):
            square = max(square, _square(x[corners[t, k]], centres[t]))
        radii[t] = math.sqrt(square)
    return centres, radii


@_compiled
def _nearest(x, p, corners, sheet_of, own, grid, first, within, w):  # type: ignore[no-untyped-def]
    """Triangle of the other sheet nearest to point p, within so many metres, or -1, and its distance; writes weights.

    first: of that sheet, with which the search begins.
    """
    centres, radii, largest, origin, size, counts, starts, listed = grid
    square, found = within * within, -1
    trial, u, v, s = _closest(x, p, corners[first])
    if trial < square:
        square, found, w[0], w[1], w[2] = trial, first, u, v, s
    distance = math.sqrt(square)
    begin, end = np.empty(3, np.int64), np.empty(3, np.int64)
    for i in range(3):
        begin[i] = max(0, math.floor((x[p, i] - distance - largest - origin[i]) / size[i]))
        end[i] = min(counts[i] - 1, math.floor((x[p, i] + distance + largest - origin[i]) / size[i]))
    if end[2] < begin[2]:
        return found, distance
    for i in range(begin[0], end[0] + 1):
        for j in range(begin[1], end[1] + 1):
            cell = (i * counts[1] + j) * counts[2]
            for number in range(starts[cell + begin[2]], starts[cell + end[2] + 1]):
                t = listed[number]
                if sheet_of[t] == own or _square(x[p], centres[t]) > (distance + radii[t]) ** 2:
                    continue
                trial, u, v, s = _closest(x, p, corners[t])
                if trial < square:
                    square, found, w[0], w[1], w[2] = trial, t, u, v, s
                    distance = math.sqrt(square)
    return found, distance


@_compiled
def _square(a, b):  # type: ignore[no-untyped-def]
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2


@_compiled
def _closest(x, p, triangle):  # type: ignore[no-untyped-def]
    a, b, c = triangle[0], triangle[1], triangle[2]
    return closest_point(
        x[p, 0], x[p, 1], x[p, 2], x[a, 0], x[a, 1], x[a, 2], x[b, 0], x[b, 1], x[b, 2], x[c, 0], x[c, 1], x[c, 2]
    )


@_compiled
def _sides(x, points, near, weights, corners, across, fans, fan_starts):  # type: ignore[no-untyped-def]
    """Clearest triangles (c,), their cosines and the greatest ones, at weights (c, 3) on triangles near (c,)."""
    clearest, cosine, greatest = near.copy(), np.zeros(len(near)), np.full(len(near), -1.0)
    pair = np.empty(2, np.int64)
    for number in range(len(near)):
        t, w = near[number], weights[number]
        way = x[points[number]].copy()
        for k in range(3):
            way -= w[k] * x[corners[t, k]]
        for other in _meeting(t, w, corners[t], across[t], fans, fan_starts, pair):
            turned = _cosine(x, corners[other], way)
            greatest[number] = max(greatest[number], turned)
            if abs(turned) > abs(cosine[number]):
                clearest[number], cosine[number] = other, turned
    return clearest, cosine, greatest


@_compiled
def _meeting(t, w, triangle, across, fans, fan_starts, pair):  # type: ignore[no-untyped-def]
    """Triangles that meet at the place of weights w (3,) on triangle t, in order; pair (2,) is room for them."""
    for k in range(3):
        if w[k] == 1.0:
            return fans[fan_starts[triangle[k]] : fan_starts[triangle[k] + 1]]
    for k in range(3):
        if w[(k + 2) % 3] == 0.0 and across[k] >= 0:
            pair[0], pair[1] = min(t, across[k]), max(t, across[k])
            return pair
    pair[0] = t
    return pair[:1]


@_compiled
def _cosine(x, triangle, way):  # type: ignore[no-untyped-def]
    """Of the angle between a way (3,) and the normal of a triangle; 0 where either has no length."""
    a, b, c = x[triangle[0]], x[triangle[1]], x[triangle[2]]
    ux, uy, uz, vx, vy, vz = b[0] - a[0], b[1] - a[1], b[2] - a[2], c[0] - a[0], c[1] - a[1], c[2] - a[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    size = (nx * nx + ny * ny + nz * nz) * (way[0] * way[0] + way[1] * way[1] + way[2] * way[2])
    return (nx * way[0] + ny * way[1] + nz * way[2]) / max(math.sqrt(size), 1e-30)


@_compiled
def _in_front(x, points, triangles, corners):  # type: ignore[no-untyped-def]
    flags = np.empty(len(points), np.bool_)
    for number in range(len(points)):
        triangle = corners[triangles[number]]
        flags[number] = _cosine(x, triangle, x[points[number]] - x[triangle[0]]) >= 0.0
    return flags
