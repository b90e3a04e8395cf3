"""How deep the points of two sheets of triangles are in each other: nearest places on the other sheet, and which side.

A point is behind where it is behind all triangles that meet at the nearest place. Triangles are sorted into a grid by
their middles.
"""

from __future__ import annotations

import math

import numpy as np

from risorius.closest_point import closest_point
from risorius.jaw import FloatArray
from risorius.lip_sheets import LipSheets, on_border
from risorius_offline.discretisation import IntArray
from risorius_offline.effects.point_triangle import compiled

DEEPEST = 5e-3  # metres; what is farther behind a sheet is not in it
CELL = 2e-3  # of the grid, metres


class SheetDepth:
    """Finds points of either sheet that are behind the other.

    rest (v, 3): points at rest, metres; sheets: numbered as these. What is nearest to a place between points of the
    border alone is not behind a sheet, and at rest such points are beside it, and take no part. Nor is behind what is
    behind the same triangle at rest: it has tissue in between.
    """

    def __init__(self, rest: FloatArray, sheets: LipSheets) -> None:
        triangles = sheets.triangles.astype(np.int64)
        border = on_border(sheets.triangles, sheets.across, len(rest))
        fans = np.argsort(triangles.ravel(), kind="stable") // 3
        fan_starts = np.concatenate([[0], np.cumsum(np.bincount(triangles.ravel(), minlength=len(rest)))])
        self._rest, self._facing, self._triangles = rest, sheets.facing.astype(np.int64), triangles
        self._sheets = (sheets.sheet, triangles, sheets.sheet_of, border)
        self._around = (triangles, sheets.across, fans, fan_starts)
        near, _ = nearest_places(rest, np.arange(len(rest)), self._facing, math.inf, *self._sheets)
        self._seeing = np.flatnonzero(near >= 0)

    def behind(self, x: FloatArray) -> tuple[IntArray, IntArray]:
        """Points (c,) that are behind, and the corners (c, 3) of the other sheet nearest to them, places x (v, 3)."""
        near, weights = nearest_places(x, self._seeing, self._facing, DEEPEST, *self._sheets)
        found = np.flatnonzero(near >= 0)
        found = found[are_behind(x, self._rest, self._seeing[found], near[found], weights[found], *self._around)]
        return self._seeing[found], self._triangles[near[found]]


@compiled
def nearest_places(x, points, facing, within, sheet, triangles, sheet_of, border):  # type: ignore[no-untyped-def]
    """Triangles (c,) of the other sheet that are nearest to points (c,), and the weights (c, 3) of the places there.

    x (v, 3); sheet (v,), triangles (m, 3), sheet_of (m,) and facing (v,) as in `LipSheets`; border (v,) flags. -1 where
    nothing is within so many metres, and where the nearest place lies between points of the border alone.
    """
    near, weights = np.empty(len(points), np.int64), np.empty((len(points), 3))
    if not len(points):
        return near, weights
    grid = _grid(x, triangles)
    for number in range(len(points)):
        p, w = points[number], weights[number]
        near[number] = _nearest(x, p, sheet[p], triangles, sheet_of, grid, facing[p], within, w)
        if near[number] >= 0 and _on_border(triangles[near[number]], border, w):
            near[number] = -1
    return near, weights


@compiled
def are_behind(x, rest, points, near, weights, triangles, across, fans, fan_starts):  # type: ignore[no-untyped-def]
    """Flags (c,) of points that are behind the places of weights (c, 3) on triangles near (c,), but were not at rest.

    fans lists the triangles around each point, from fan_starts on.
    """
    flags = np.empty(len(points), np.bool_)
    for number in range(len(points)):
        p, t = points[number], near[number]
        flags[number] = _is_behind(x, p, t, weights[number], triangles, across, fans, fan_starts)
        flags[number] &= _normal(rest, triangles[t]) @ (rest[p] - rest[triangles[t, 0]]) >= 0.0
    return flags


@compiled
def _grid(x, triangles):  # type: ignore[no-untyped-def]
    """Middles and radii of triangles; origin, cells along the axes, and what is in each cell.

    That is (starts, listed): triangles by cell, and where those of each begin.
    """
    centres, radii = _middles(x, triangles)
    low, high = centres[0].copy(), centres[0].copy()
    for t in range(len(centres)):
        for i in range(3):
            low[i], high[i] = min(low[i], centres[t, i]), max(high[i], centres[t, i])
    counts = np.ones(3, np.int64)
    for i in range(3):
        counts[i] = int((high[i] - low[i]) / CELL) + 1
    starts = np.zeros(counts[0] * counts[1] * counts[2] + 1, np.int64)
    cells = np.zeros(len(centres), np.int64)
    for t in range(len(centres)):
        for i in range(3):
            cells[t] = cells[t] * counts[i] + int((centres[t, i] - low[i]) / CELL)
        starts[cells[t] + 1] += 1
    starts = np.cumsum(starts)
    listed, place = np.empty(len(centres), np.int64), starts.copy()
    for t in range(len(centres)):
        listed[place[cells[t]]] = t
        place[cells[t]] += 1
    return centres, radii, radii.max(), low, counts, starts, listed


@compiled
def _middles(x, triangles):  # type: ignore[no-untyped-def]
    """Middles (m, 3) of triangles, and the distances (m,) of their farthest corners."""
    centres, radii = np.empty((len(triangles), 3)), np.empty(len(triangles))
    for t in range(len(triangles)):
        for i in range(3):
            centres[t, i] = (x[triangles[t, 0], i] + x[triangles[t, 1], i] + x[triangles[t, 2], i]) / 3.0
        square = 0.0
        for k in range(3):
            square = max(square, _square(x[triangles[t, k]], centres[t]))
        radii[t] = math.sqrt(square)
    return centres, radii


@compiled
def _nearest(x, p, own, triangles, sheet_of, grid, first, within, w):  # type: ignore[no-untyped-def]
    """Triangle of the other sheet nearest to point p, within so many metres, or -1; writes the weights of the place.

    first: of that sheet, with which the search begins.
    """
    centres, radii, largest, origin, counts, starts, listed = grid
    square, found = within * within, -1
    trial, u, v, s = _closest(x, p, triangles[first])
    if trial < square:
        square, found, w[0], w[1], w[2] = trial, first, u, v, s
    distance = math.sqrt(square)
    begin, end = np.empty(3, np.int64), np.empty(3, np.int64)
    for i in range(3):
        begin[i] = max(0, math.floor((x[p, i] - distance - largest - origin[i]) / CELL))
        end[i] = min(counts[i] - 1, math.floor((x[p, i] + distance + largest - origin[i]) / CELL))
    if end[2] < begin[2]:
        return found
    for i in range(begin[0], end[0] + 1):
        for j in range(begin[1], end[1] + 1):
            cell = (i * counts[1] + j) * counts[2]
            for number in range(starts[cell + begin[2]], starts[cell + end[2] + 1]):
                t = listed[number]
                if sheet_of[t] == own or _square(x[p], centres[t]) > (distance + radii[t]) ** 2:
                    continue
                trial, u, v, s = _closest(x, p, triangles[t])
                if trial < square:
                    square, found, w[0], w[1], w[2] = trial, t, u, v, s
                    distance = math.sqrt(square)
    return found


@compiled
def _square(a, b):  # type: ignore[no-untyped-def]
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2


@compiled
def _closest(x, p, corners):  # type: ignore[no-untyped-def]
    a, b, c = corners[0], corners[1], corners[2]
    return closest_point(
        x[p, 0], x[p, 1], x[p, 2], x[a, 0], x[a, 1], x[a, 2], x[b, 0], x[b, 1], x[b, 2], x[c, 0], x[c, 1], x[c, 2]
    )


@compiled
def _on_border(corners, border, w):  # type: ignore[no-untyped-def]
    """Whether the place of weights w (3,) lies between points of the border alone."""
    inside = False
    for k in range(3):
        inside |= w[k] > 0.0 and not border[corners[k]]
    return not inside


@compiled
def _is_behind(x, p, t, w, triangles, across, fans, fan_starts):  # type: ignore[no-untyped-def]
    """Whether point p is behind all triangles that meet at its nearest place, of weights w (3,) on triangle t."""
    corners = triangles[t]
    way = x[p] - w[0] * x[corners[0]] - w[1] * x[corners[1]] - w[2] * x[corners[2]]
    for k in range(3):
        if w[k] == 1.0:
            for number in range(fan_starts[corners[k]], fan_starts[corners[k] + 1]):
                if _normal(x, triangles[fans[number]]) @ way >= 0.0:
                    return False
            return True
    if _normal(x, corners) @ way >= 0.0:
        return False
    for k in range(3):
        beyond = across[t, (k + 1) % 3]
        if w[k] == 0.0 and beyond >= 0 and _normal(x, triangles[beyond]) @ way >= 0.0:
            return False
    return True


@compiled
def _normal(x, corners):  # type: ignore[no-untyped-def]
    """Unit normal (3,) of a triangle."""
    normal = np.cross(x[corners[1]] - x[corners[0]], x[corners[2]] - x[corners[0]])
    return normal / max(math.sqrt(normal @ normal), 1e-30)
