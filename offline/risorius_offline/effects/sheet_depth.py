"""How deep the points of two sheets of triangles are in each other: nearest places on the other sheet, and which side.

The side is that of the angle-weighted pseudonormal at the nearest place (Baerentzen and Aanaes 2005): it is right also
where that lies on an edge or a corner, and the depth is continuous. Triangles are sorted into a grid by their middles.
"""

from __future__ import annotations

import math

import numpy as np

from risorius.closest_point import closest_point
from risorius.jaw import FloatArray
from risorius.lip_sheets import LipSheets
from risorius_offline.discretisation import IntArray
from risorius_offline.effects.point_triangle import compiled

DEEPEST = 5e-3  # metres; what is farther behind a sheet is not in it
CELL = 2e-3  # of the grid, metres
# Of the points, that may have got to the other sheet since all were looked at, from which all are looked at again.
TOO_MANY = 0.25


class SheetDepth:
    """Finds points of either sheet that are behind the other.

    rest (v, 3): points at rest, metres; sheets: numbered as these. What is nearest to a place between points of the
    border alone is not behind a sheet, and at rest such points are beside it, and take no part. Nor is behind what is
    behind the same triangle at rest: it has tissue in between.
    """

    def __init__(self, rest: FloatArray, sheets: LipSheets) -> None:
        self._rest = rest
        border = np.zeros(len(rest), dtype=bool)
        border[np.stack([sheets.triangles, np.roll(sheets.triangles, -1, axis=1)], axis=2)[sheets.across < 0]] = True
        order = np.argsort(sheets.triangles.ravel(), kind="stable")
        starts = np.concatenate([[0], np.cumsum(np.bincount(sheets.triangles.ravel(), minlength=len(rest)))])
        self._sheet = sheets.sheet.astype(np.int64)
        self._sheets = (self._sheet, sheets.triangles.astype(np.int64), sheets.sheet_of, border)
        self._around = (sheets.across, order // 3, starts)
        everyone = np.arange(len(rest))
        gaps, near, _ = nearest_places(rest, everyone, sheets.facing.astype(np.int64), math.inf, *self._sheets)
        self._seeing = everyone[gaps > 0.0]
        self._seen_at, self._gaps, self._near = rest, gaps[self._seeing], near[self._seeing]

    def behind(self, x: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
        """Points (c,) that are behind, triangles (c,) nearest to them and the weights (c, 3) there, at places x (v, 3).

        A point that has come nearer to the other sheet by less than its gap, when all were looked at, is not behind.
        """
        moved = np.linalg.norm(x - self._seen_at, axis=1)
        nearer = moved + np.array([moved[self._sheet == side].max(initial=0.0) for side in (1, 0)])[self._sheet]
        open_to = np.flatnonzero(nearer[self._seeing] >= self._gaps)
        if len(open_to) > TOO_MANY * len(self._seeing):
            open_to = np.arange(len(self._seeing))
        points = self._seeing[open_to]
        gaps, near, weights = nearest_places(x, points, self._near[open_to], DEEPEST, *self._sheets)
        gaps, found = signed_gaps(x, self._rest, points, gaps, near, weights, *self._sheets[:2], *self._around)
        if len(open_to) == len(self._seeing):
            self._seen_at, self._gaps, self._near = x, gaps, near
        return points[found], near[found], weights[found]


@compiled
def nearest_places(x, points, first, within, sheet, triangles, sheet_of, border):  # type: ignore[no-untyped-def]
    """Gaps (c,), triangles (c,) of the other sheet that are nearest to points (c,), and the weights (c, 3) there.

    x (v, 3); sheet (v,), triangles (m, 3) and sheet_of (m,) as in `LipSheets`; border (v,) flags. first (c,): triangles
    that the searches begin with, kept where nothing is within so many metres, which is the gap then. The gap is zero
    where the nearest place lies between points of the border alone.
    """
    grid = _grid(x, triangles)
    gaps, near, weights = np.empty(len(points)), first.copy(), np.empty((len(points), 3))
    for number in range(len(points)):
        p, w = points[number], weights[number]
        square, t = _nearest(x, p, sheet[p], triangles, sheet_of, grid, first[number], within, w)
        gaps[number] = math.sqrt(square)
        if t >= 0:
            near[number] = t
            if _on_border(triangles[t], border, w):
                gaps[number] = 0.0
    return gaps, near, weights


@compiled
def signed_gaps(x, rest, points, gaps, near, weights, sheet, triangles, across, fans, fan_starts):  # type: ignore[no-untyped-def]
    """Gaps (c,) that are zero for points that are behind, and which (k,) of the points are, by `nearest_places`.

    across (m, 3) as in `LipSheets`; fans lists the triangles around each point, from fan_starts on.
    """
    gaps, found, count = gaps.copy(), np.empty(len(points), np.int64), 0
    for number in range(len(points)):
        if not 0.0 < gaps[number] < DEEPEST:
            continue
        p, t, w = points[number], near[number], weights[number]
        if _height_over_nearest(x, p, t, w, triangles, across, fans, fan_starts) >= 0.0:
            continue
        gaps[number] = 0.0
        if _normal(rest, triangles[t]) @ (rest[p] - rest[triangles[t, 0]]) >= 0.0:
            found[count] = number
            count += 1
    return gaps, found[:count]


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
    """Square of the distance of point p from the other sheet, within so many metres, and the triangle, or -1.

    Writes the weights of the nearest place; first is where the search begins.
    """
    centres, radii, largest, origin, counts, starts, listed = grid
    square, found = within * within, -1
    trial, u, v, s = _closest(x, p, triangles[first])
    if trial < square:
        square, found, w[0], w[1], w[2] = trial, first, u, v, s
    distance = math.sqrt(square)
    begin, end = np.empty(3, np.int64), np.empty(3, np.int64)
    for i in range(3):
        begin[i] = max(0, int(math.floor((x[p, i] - distance - largest - origin[i]) / CELL)))
        end[i] = min(counts[i] - 1, int(math.floor((x[p, i] + distance + largest - origin[i]) / CELL)))
    if end[2] < begin[2]:
        return square, found
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
    return square, found


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
    for k in range(3):
        if w[k] > 0.0 and not border[corners[k]]:
            return False
    return True


@compiled
def _height_over_nearest(x, p, t, w, triangles, across, fans, fan_starts):  # type: ignore[no-untyped-def]
    """Height of point p over its nearest place, of weights w (3,) on triangle t, times a positive number."""
    corners = triangles[t]
    way = x[p] - w[0] * x[corners[0]] - w[1] * x[corners[1]] - w[2] * x[corners[2]]
    for k in range(3):
        if w[k] == 1.0:
            return _at_corner(x, corners[k], triangles, fans, fan_starts) @ way
    normal = _normal(x, corners)
    for k in range(3):
        if w[k] == 0.0 and across[t, (k + 1) % 3] >= 0:
            normal += _normal(x, triangles[across[t, (k + 1) % 3]])
    return normal @ way


@compiled
def _at_corner(x, corner, triangles, fans, fan_starts):  # type: ignore[no-untyped-def]
    """Pseudonormal (3,): of the triangles around a point, by the angles that they have there."""
    normal = np.zeros(3)
    for number in range(fan_starts[corner], fan_starts[corner + 1]):
        a, b, c = triangles[fans[number]]
        other, last = (b, c) if corner == a else ((c, a) if corner == b else (a, b))
        one, two = x[other] - x[corner], x[last] - x[corner]
        cross = np.cross(one, two)
        normal += math.atan2(math.sqrt(cross @ cross), one @ two) * _normal(x, triangles[fans[number]])
    return normal


@compiled
def _normal(x, corners):  # type: ignore[no-untyped-def]
    """Unit normal (3,) of a triangle."""
    normal = np.cross(x[corners[1]] - x[corners[0]], x[corners[2]] - x[corners[0]])
    return normal / max(math.sqrt(normal @ normal), 1e-30)
