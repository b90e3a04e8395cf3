"""Which nodes of a surface may be near which of its triangles: a uniform grid of boxes, and a list that is kept."""

from __future__ import annotations

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray
from risorius_offline.effects.contact_surface import ContactSurface, admitted
from risorius_offline.effects.point_triangle import compiled

_MOST_CELLS = 64  # along an axis


class PairList:
    """Pairs (k, 2) of node and triangle that are admitted and nearer than `reach` metres; some are farther.

    seeing: numbers of the nodes that pairs are wanted of. The list is sorted by node, made with a margin (metres) and
    kept until a node has moved by half of it since.
    """

    def __init__(self, surface: ContactSurface, seeing: IntArray, reach: float, margin: float) -> None:
        self._surface, self._seeing = surface, seeing
        self._reach, self._margin = reach, margin
        self._made_at: FloatArray | None = None
        self._pairs = np.zeros((0, 2), dtype=np.int64)

    def at(self, x: FloatArray) -> IntArray:
        """Pairs at node positions x (b, 3)."""
        if self._made_at is None or not _within(x, self._made_at, 0.5 * self._margin):
            self._pairs = self._search(x, x, self._reach + self._margin)
            self._made_at = x
        return self._pairs

    def swept(self, x: FloatArray, motion: FloatArray) -> IntArray:
        """Pairs that come nearer than the reach anywhere on the straight way from x to x + motion."""
        return self._search(x, x + motion, self._reach)

    def _search(self, start: FloatArray, end: FloatArray, reach: float) -> IntArray:
        low, high = np.minimum(start, end), np.maximum(start, end)
        triangles = self._surface.triangles
        boxes = _around_corners(low, high, triangles)
        return overlapping_boxes(self._seeing, low - reach, high + reach, *boxes, triangles, self._surface.bone)


@compiled
def _within(x, y, distance):  # type: ignore[no-untyped-def]
    """Whether no row of x is farther than `distance` from that of y."""
    for n in range(len(x)):
        square = 0.0
        for i in range(3):
            square += (x[n, i] - y[n, i]) ** 2
        if not square <= distance * distance:
            return False
    return True


@compiled
def _around_corners(low, high, triangles):  # type: ignore[no-untyped-def]
    """Boxes (m, 3) and (m, 3) around the boxes (b, 3) and (b, 3) of the corners of triangles."""
    below, above = low[triangles[:, 0]], high[triangles[:, 0]]
    for t in range(len(triangles)):
        for a in range(1, 3):
            for i in range(3):
                below[t, i] = min(below[t, i], low[triangles[t, a], i])
                above[t, i] = max(above[t, i], high[triangles[t, a], i])
    return below, above


@compiled
def _cell(position, origin, size, counts, cell):  # type: ignore[no-untyped-def]
    """Write the grid cell of a position, the outermost one for positions outside or not finite."""
    for i in range(3):
        place = (position[i] - origin[i]) / size[i]
        cell[i] = 0
        if place >= counts[i]:
            cell[i] = counts[i] - 1
        elif place > 0.0:
            cell[i] = int(place)


@compiled
def _grid(low, high):  # type: ignore[no-untyped-def]
    """Origin, cell size and number of cells along the axes of a grid whose cells are like the mean box."""
    origin, end, mean = low[0].copy(), high[0].copy(), np.zeros(3)
    for t in range(len(low)):
        for i in range(3):
            origin[i] = min(origin[i], low[t, i])
            end[i] = max(end[i], high[t, i])
            mean[i] += (high[t, i] - low[t, i]) / len(low)
    size, counts = np.ones(3), np.ones(3, dtype=np.int64)
    for i in range(3):
        extent = end[i] - origin[i]
        if mean[i] > 0.0 and extent < np.inf:
            counts[i] = min(max(int(extent / mean[i]), 1), _MOST_CELLS)
            size[i] = extent / counts[i]
    return origin, size, counts


@compiled
def _fill(low, high, origin, size, counts):  # type: ignore[no-untyped-def]
    """First and last cell (m, 2, 3) of every box, and the boxes of every cell as (starts, boxes)."""
    cells = np.empty((len(low), 2, 3), dtype=np.int64)
    starts = np.zeros(counts[0] * counts[1] * counts[2] + 1, dtype=np.int64)
    for t in range(len(low)):
        _cell(low[t], origin, size, counts, cells[t, 0])
        _cell(high[t], origin, size, counts, cells[t, 1])
        for i in range(cells[t, 0, 0], cells[t, 1, 0] + 1):
            for j in range(cells[t, 0, 1], cells[t, 1, 1] + 1):
                for k in range(cells[t, 0, 2], cells[t, 1, 2] + 1):
                    starts[(i * counts[1] + j) * counts[2] + k + 1] += 1
    starts = np.cumsum(starts)
    boxes, place = np.empty(starts[-1], dtype=np.int64), starts.copy()
    for t in range(len(low)):
        for i in range(cells[t, 0, 0], cells[t, 1, 0] + 1):
            for j in range(cells[t, 0, 1], cells[t, 1, 1] + 1):
                for k in range(cells[t, 0, 2], cells[t, 1, 2] + 1):
                    number = (i * counts[1] + j) * counts[2] + k
                    boxes[place[number]] = t
                    place[number] += 1
    return cells, starts, boxes


@compiled
def overlapping_boxes(seeing, node_low, node_high, low, high, triangles, bone):  # type: ignore[no-untyped-def]
    """Admitted pairs (k, 2) of boxes of seeing nodes (b, 3) and of triangles (m, 3) that overlap, each pair once."""
    origin, size, counts = _grid(low, high)
    cells, starts, boxes = _fill(low, high, origin, size, counts)
    pairs = np.empty((4096, 2), dtype=np.int64)
    found = 0
    first, last = np.empty(3, dtype=np.int64), np.empty(3, dtype=np.int64)
    for p in seeing:
        _cell(node_low[p], origin, size, counts, first)
        _cell(node_high[p], origin, size, counts, last)
        for i in range(first[0], last[0] + 1):
            for j in range(first[1], last[1] + 1):
                for k in range(first[2], last[2] + 1):
                    number = (i * counts[1] + j) * counts[2] + k
                    for b in range(starts[number], starts[number + 1]):
                        t = boxes[b]
                        own = cells[t, 0]
                        # Boxes share many cells; the pair belongs to the lowest of them.
                        if i != max(first[0], own[0]) or j != max(first[1], own[1]) or k != max(first[2], own[2]):
                            continue
                        apart = False
                        for axis in range(3):
                            apart |= node_high[p, axis] < low[t, axis] or node_low[p, axis] > high[t, axis]
                        if apart or not admitted(p, t, triangles, bone):
                            continue
                        if found == len(pairs):
                            pairs = np.concatenate((pairs, np.empty_like(pairs)))
                        pairs[found, 0], pairs[found, 1] = p, t
                        found += 1
    return pairs[:found].copy()
