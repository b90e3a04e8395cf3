"""A finer, smoother triangulation carried by a coarse one: square-root-of-three subdivision (Kobbelt 2000).

A step puts a point into the middle of every triangle, joins it to those of the neighbours across each old edge, and
smooths the old points. In every second step the boundary follows: its edges are cut into three by the interpolating
four-point scheme of Hassan, Ivrissimitzis, Dodgson and Sabin (2002), which keeps the old points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from risorius.errors import InputError
from risorius_offline.discretisation import IntArray

_TENSION = 1.0 / 11.0  # smooth to the second derivative between 1/15 and 1/9
# Shares of the boundary points before, at both ends of and after an edge in its point at one third.
_THIRD = np.array([-1.0 - 3.0 * _TENSION, 13.0 + 9.0 * _TENSION, 7.0 - 9.0 * _TENSION, -1.0 + 3.0 * _TENSION]) / 18.0


def refine(triangles: IntArray, count: int, steps: int) -> tuple[sp.csr_matrix, IntArray]:
    """Weights (fine, count) and triangles after some steps; every step has three times as many triangles.

    Fine points are weights @ coarse points, old ones first, and smooth where the surface goes on; old points on its
    boundary stay where they are. Rows of the weights sum to one. Raises InputError where the surface is not a manifold
    or its triangles do not turn the same way.
    """
    weights = sp.identity(count, format="csr")
    for number in range(steps):
        edges = _Edges.of(triangles, weights.shape[0])
        step, triangles = _inner_step(edges) if number % 2 == 0 else _boundary_step(edges)
        weights = (step @ weights).tocsr()
    return weights, triangles


@dataclass(frozen=True)
class _Edges:
    """Directed edges (3 t) of triangles, three for each: where they start and end, and their twin, -1 where none is.

    count: of the points. open: numbers of the edges without a twin.
    """

    count: int
    start: IntArray
    end: IntArray
    twin: IntArray
    open: IntArray

    @classmethod
    def of(cls, triangles: IntArray, count: int) -> _Edges:
        start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
        key, wanted = start * count + end, end * count + start
        order = np.argsort(key)
        double = order[np.flatnonzero(np.diff(key[order]) == 0)]
        if len(double):
            raise InputError(
                f"surface: two triangles run from point {start[double[0]]} to point {end[double[0]]}; "
                "let each edge have one triangle on either side, and all triangles turn the same way"
            )
        found = order[np.minimum(np.searchsorted(key, wanted, sorter=order), len(key) - 1)]
        twin = np.where(key[found] == wanted, found, -1)
        opened = np.flatnonzero(twin < 0)
        pinched = np.flatnonzero(np.bincount(start[opened], minlength=count) > 1)
        if len(pinched):
            raise InputError(f"surface: its boundary meets itself in point {pinched[0]}; give each side a point there")
        return cls(count, start, end, twin, opened)

    @property
    def following(self) -> IntArray:
        """(3 t,) the next edge of the same triangle."""
        return np.arange(len(self.start)).reshape(-1, 3)[:, [1, 2, 0]].ravel()

    @property
    def neighbours(self) -> sp.csr_matrix:
        """(count, count) 1 where an edge runs from the row to the column."""
        return self.matrix(self.start, self.end, 1.0)

    def matrix(self, rows: IntArray, columns: IntArray, value: float) -> sp.csr_matrix:
        """(count, count) with one value at all given places."""
        return sp.csr_matrix((np.full(len(rows), value), (rows, columns)), shape=(self.count, self.count))

    def joined(self, middle: IntArray) -> IntArray:
        """Triangles on both sides of every inner edge, between its ends and the new points (3 t,) seen from it."""
        inner = np.flatnonzero(self.twin >= 0)
        return np.column_stack([self.start[inner], middle[self.twin[inner]], middle[inner]])


def _inner_step(edges: _Edges) -> tuple[sp.csr_matrix, IntArray]:
    """Weights and triangles of a step that keeps the edges of the boundary."""
    middle = edges.count + np.repeat(np.arange(len(edges.start) // 3), 3)
    at_boundary = np.column_stack([edges.start[edges.open], edges.end[edges.open], middle[edges.open]])
    weights = sp.vstack([_smoothed(edges, edges.neighbours), _middles(edges)])
    return weights, np.concatenate([edges.joined(middle), at_boundary])


def _boundary_step(edges: _Edges) -> tuple[sp.csr_matrix, IntArray]:
    """Weights and triangles of a step after `_inner_step`: triangles have one open edge at most.

    One with an open edge gets no point in its middle: the two on the open edge are there in its stead, each for the
    inner edge next to it. The neighbour that its tip has on the other side of other edges is put there by reflection.
    """
    opened, apart = edges.open, edges.following[edges.following[edges.open]]
    closed = np.ones(len(edges.start) // 3, dtype=bool)
    closed[opened // 3] = False
    middle = edges.count + np.repeat(np.cumsum(closed) - 1, 3)
    near_start = edges.count + closed.sum() + np.arange(len(opened))
    near_end = near_start + len(opened)
    middle[apart], middle[edges.following[opened]] = near_start, near_end
    tip = edges.start[apart]
    reflected = [(tip, edges.start[opened], 1.0), (tip, edges.end[opened], 1.0), (tip, tip, -1.0)]
    neighbours = edges.neighbours + sum(edges.matrix(*entries) for entries in reflected)
    weights = sp.vstack([_smoothed(edges, neighbours), _middles(edges)[closed], *_thirds(edges)])
    return weights, np.concatenate([edges.joined(middle), np.column_stack([near_start, near_end, tip])])


def _smoothed(edges: _Edges, neighbours: sp.csr_matrix) -> sp.csr_matrix:
    """Weights (count, count) of the old points: inner ones move towards the mean of their neighbours."""
    valence = np.asarray(neighbours.sum(axis=1)).ravel()
    inner = valence > 0.0
    inner[edges.start[edges.open]] = False
    valence[~inner] = 1.0
    share = np.where(inner, (4.0 - 2.0 * np.cos(2.0 * np.pi / valence)) / 9.0, 0.0)
    return sp.diags(1.0 - share) + sp.diags(share / valence) @ neighbours


def _middles(edges: _Edges) -> sp.csr_matrix:
    """Weights (t, count) of the middles of all triangles."""
    count = len(edges.start) // 3
    rows = np.repeat(np.arange(count), 3)
    return sp.csr_matrix((np.full(len(rows), 1.0 / 3.0), (rows, edges.start)), shape=(count, edges.count))


def _thirds(edges: _Edges) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Weights (open, count) of the points at one third and at two thirds of every open edge."""
    start, end = edges.start[edges.open], edges.end[edges.open]
    before, after = np.zeros((2, edges.count), dtype=np.int64)
    before[end], after[start] = start, end
    line = np.column_stack([before[start], start, end, after[end]])
    first, second = (
        sp.csr_matrix(
            (np.tile(shares, len(line)), line.ravel(), 4 * np.arange(len(line) + 1)), (len(line), edges.count)
        )
        for shares in (_THIRD, _THIRD[::-1])
    )
    return first, second
