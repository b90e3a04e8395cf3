"""Walls against inverted cells, as in `mechanics.wall`, in vector lanes and with a relaxed barrier."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from risorius.hyper_reduction.lanes import (
    FLOOR,
    add_divergence,
    cofactor_changes,
    cofactors,
    compiled,
    contract,
    gradient_at,
)
from risorius.hyper_reduction.terms import Floats
from risorius.mechanics.body import WallCells


class Walls:
    """Cells of one kind with a state: at rest at first. Forces and products are overwritten by the next call.

    dtype: floating type of all arrays.
    """

    def __init__(self, cells: WallCells, dtype: npt.DTypeLike = np.float64) -> None:
        count, (nodes, _, points) = len(cells.weights), cells.gradients.shape
        self.connectivity = cells.connectivity
        slopes = cells.gradients.reshape(3 * nodes, points).T[:, :, None]
        self._gradients = np.ascontiguousarray(np.broadcast_to(slopes, (points, 3 * nodes, count)), dtype)
        at_rest = np.einsum("eai,ajk->kije", cells.corners, cells.gradients).reshape(points, 9, count)
        self._at_rest = np.ascontiguousarray(at_rest, dtype)
        self._form = cells.form.astype(dtype)
        self._heights = np.ascontiguousarray(cells.heights.T, dtype)
        self._weights = cells.weights.astype(dtype)
        self._A, self._G = np.empty((points, 9, count), dtype), np.empty((points, 9, count), dtype)
        self._D, self._slopes = np.empty((points, count), dtype), np.empty((points, count), dtype)
        self._ratios, self._curvatures = np.empty_like(self._heights), np.empty_like(self._heights)
        self._work = np.empty((points, 9, count), dtype), np.empty((9, count), dtype), np.empty((points, count), dtype)
        self._forces = np.empty((3 * nodes, count), dtype)

    def deform(self, u: Floats) -> None:
        """Take the displacement (3 a, e) of the nodes of every cell, metres."""
        tables = self._at_rest, self._gradients, self._form, self._heights, self._weights
        _deform(u, *tables, self._A, self._G, self._D, self._ratios, self._slopes, self._curvatures)

    def energy(self) -> float:
        """Joules."""
        return float(_energy(self._ratios, self._weights))

    def forces(self) -> Floats:
        """Derivatives (3 a, e) of the energy by the displacement, newtons."""
        _add_forces(self._G, self._slopes, self._gradients, self._work[1], self._forces)
        return self._forces

    def product(self, v: Floats) -> Floats:
        """Change (3 a, e) of the forces with a change v (3 a, e) of the displacement."""
        state = self._A, self._G, self._slopes, self._curvatures
        _product(v, *state, self._gradients, self._form, *self._work, self._forces)
        return self._forces

    def smallest_jacobian(self) -> float:
        """Infinite: walls are not where J is looked at."""
        return np.inf


@compiled
def relaxed_barrier(s):  # type: ignore[no-untyped-def]
    """B of `mechanics.wall` and its derivatives at any s, continued to second order below FLOOR."""
    if s >= 1.0:
        return 0.0, 0.0, 0.0
    bounded = max(s, FLOOR)
    y, log, x = 1.0 - bounded, math.log(bounded), s - bounded
    value, slope = -y * y * log, 2.0 * y * log - y * y / bounded
    curvature = -2.0 * log + 4.0 * y / bounded + (y / bounded) ** 2
    return value + x * slope + 0.5 * x * x * curvature, slope + x * curvature, curvature


@compiled
def _deform(  # type: ignore[no-untyped-def]
    u, at_rest, gradients, form, heights, weights, A, G, D, ratios, slopes, curvatures
):
    """Write dx/dxi, its cofactor (k, 9, e) and determinant D (k, e); s (m, e), dE/dD (k, e), d2E/db2 (m, e)."""
    for q in range(len(gradients)):
        gradient_at(u, gradients[q], A[q])
        for i in range(9):
            for e in range(len(weights)):
                A[q, i, e] += at_rest[q, i, e]
        cofactors(A[q], G[q], D[q])
    slopes[:] = 0.0
    for m in range(len(form)):
        ratios[m] = 0.0
        for q in range(len(gradients)):
            for e in range(len(weights)):
                ratios[m, e] += form[m, q] * D[q, e]
        for e in range(len(weights)):
            ratios[m, e] /= heights[m, e]
            _, slope, curvature = relaxed_barrier(ratios[m, e])
            curvatures[m, e] = weights[e] * curvature / heights[m, e] ** 2
            if slope != 0.0:
                for q in range(len(gradients)):
                    slopes[q, e] += form[m, q] * weights[e] * slope / heights[m, e]


@compiled
def _energy(ratios, weights):  # type: ignore[no-untyped-def]
    total = 0.0
    for m in range(len(ratios)):
        for e in range(len(weights)):
            total += weights[e] * relaxed_barrier(ratios[m, e])[0]
    return total


@compiled
def _add_forces(G, slopes, gradients, P, forces):  # type: ignore[no-untyped-def]
    forces[:] = 0.0
    for q in range(len(gradients)):
        for k in range(9):
            for e in range(P.shape[1]):
                P[k, e] = slopes[q, e] * G[q, k, e]
        add_divergence(P, gradients[q], forces)


@compiled
def _product(v, A, G, slopes, curvatures, gradients, form, changes, P, points, forces):  # type: ignore[no-untyped-def]
    """Write the change of the forces; changes, P, points are working space."""
    count = P.shape[1]
    for q in range(len(gradients)):
        gradient_at(v, gradients[q], changes[q])
        contract(G[q], changes[q], points[q])
    forces[:] = 0.0
    for q in range(len(gradients)):
        cofactor_changes(A[q], changes[q], P)
        for k in range(9):
            for e in range(count):
                P[k, e] *= slopes[q, e]
        add_divergence(P, gradients[q], forces)
    for m in range(len(form)):
        for e in range(count):
            if curvatures[m, e] == 0.0:
                continue
            change = 0.0
            for q in range(len(gradients)):
                change += form[m, q] * points[q, e]
            change *= curvatures[m, e]
            for q in range(len(gradients)):
                _add_rank_one(change * form[m, q], G[q], gradients[q], e, forces)


@compiled
def _add_rank_one(scale, G, gradients, e, forces):  # type: ignore[no-untyped-def]
    """Add scale G grad N_a to the forces of one cell."""
    for a in range(0, len(forces), 3):
        for i in range(3):
            for j in range(3):
                forces[a + i, e] += scale * G[3 * i + j, e] * gradients[a + j, e]
