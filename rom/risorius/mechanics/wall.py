"""A wall that keeps J > 0 everywhere in a cell, not only at its quadrature points.

det(dx/dxi) of a deformed cell is positive where its Bernstein coefficients b are (Johnen, Remacle and Geuzaine 2013);
r are those at rest. Every coefficient contributes w B(b / (r h)) to the energy, with a height h of the wall and

    B(s) = -(1 - s)^2 ln s  for s < 1, and 0 above

(Li et al. 2020), which is twice continuously differentiable: a cell that is squeezed nowhere below h does not feel it.

Arrays of one block of cells: positions x (n, 3), cells (c,) the numbers of those that have the wall, connectivity
(e, a), gradients (a, 3, k) of the shape functions by xi at k points, form (m, k) from determinants there to
coefficients, heights (c, m) = r h in cubic metres, weights (c,) = w in joules.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from risorius.mechanics.point import inlined

_compiled = numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz", "arcp", "reassoc"})


@inlined
def barrier(s):  # type: ignore[no-untyped-def]
    """B and its first and second derivative at 0 < s < 1."""
    y, log = 1.0 - s, math.log(s)
    return -y * y * log, 2.0 * y * log - y * y / s, -2.0 * log + 4.0 * y / s + (y / s) ** 2


@_compiled
def _ratios(x, nodes, gradients, form, heights, A, G, determinants, ratios):  # type: ignore[no-untyped-def]
    """Write dx/dxi and cofactors into A, G (9, k), determinants (k,) and b / (r h) (m,); return the smallest ratio.

    Inner loops are along the points, which compilers make vector instructions of.
    """
    points = len(determinants)
    A[:] = 0.0
    for a in range(len(nodes)):
        for i in range(3):
            position = x[nodes[a], i]
            for j in range(3):
                for q in range(points):
                    A[3 * i + j, q] += position * gradients[a, j, q]
    for i in range(3):
        k, m = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            p, n = (j + 1) % 3, (j + 2) % 3
            for q in range(points):
                G[3 * i + j, q] = A[3 * k + p, q] * A[3 * m + n, q] - A[3 * k + n, q] * A[3 * m + p, q]
    for q in range(points):
        determinants[q] = A[0, q] * G[0, q] + A[1, q] * G[1, q] + A[2, q] * G[2, q]
    smallest = math.inf
    for i in range(len(form)):
        b = 0.0
        for q in range(points):
            b += form[i, q] * determinants[q]
        ratios[i] = b / heights[i]
        smallest = min(smallest, ratios[i])
    return smallest


@_compiled
def energy_and_forces(  # type: ignore[no-untyped-def]
    x, cells, connectivity, gradients, form, heights, weights, with_forces, forces
):
    """Energy (J); adds nodal forces (N) to `forces` (n, 3). Infinite where a coefficient is not positive."""
    points = gradients.shape[2]
    A, G, determinants = np.empty((9, points)), np.empty((9, points)), np.empty(points)
    ratios, slopes = np.empty(len(form)), np.empty(points)
    total = 0.0
    for c in range(len(cells)):
        e = cells[c]
        smallest = _ratios(x, connectivity[e], gradients, form, heights[c], A, G, determinants, ratios)
        if smallest >= 1.0:
            continue
        if smallest <= 0.0:
            total = math.inf
            continue
        slopes[:] = 0.0
        for i in range(len(form)):
            if ratios[i] < 1.0:
                energy, slope, _ = barrier(ratios[i])
                total += weights[c] * energy
                for q in range(points):
                    slopes[q] += weights[c] * slope / heights[c, i] * form[i, q]
        if not with_forces:
            continue
        for a in range(connectivity.shape[1]):
            for i in range(3):
                force = 0.0
                for j in range(3):
                    for q in range(points):
                        force += slopes[q] * G[3 * i + j, q] * gradients[a, j, q]
                forces[connectivity[e, a], i] += force
    return total


@_compiled
def _scatter(K, T, positions, values):  # type: ignore[no-untyped-def]
    """Add K minus T with the components of its two nodes exchanged to the stored entries of a matrix."""
    nodes = K.shape[0] // 3
    for a in range(nodes):
        for i in range(3):
            for b in range(nodes):
                for j in range(3):
                    position = positions[3 * a + i, 3 * b + j]
                    if position >= 0:
                        values[position] += K[3 * a + i, 3 * b + j] - T[3 * a + j, 3 * b + i]


@_compiled
def tangent(  # type: ignore[no-untyped-def]
    x, cells, connectivity, gradients, form, heights, weights, project, scatter, values
):
    """Add second derivatives (N/m) to `values`, the entries of a sparse matrix, where all coefficients are positive.

    scatter (e, 3 a, 3 a): position in `values` of every entry, -1 for entries that are not stored. `project` leaves out
    the second derivatives of b: what is left is positive semi-definite. With the determinant D of a point and its
    derivatives g_a by the position of node a, these are the sum over points of a number times

        d2D / dx_a dx_b = (g_a g_b^T - g_b g_a^T) / D
    """
    points, nodes = gradients.shape[2], connectivity.shape[1]
    A, G, determinants = np.empty((9, points)), np.empty((9, points)), np.empty(points)
    ratios, slopes, curvatures = np.empty(len(form)), np.empty(points), np.empty((points, points))
    vectors, scaled = np.empty((points, 3 * nodes)), np.zeros((points, 3 * nodes))
    K, T = np.empty((3 * nodes, 3 * nodes)), np.empty((3 * nodes, 3 * nodes))
    for c in range(len(cells)):
        e = cells[c]
        if _ratios(x, connectivity[e], gradients, form, heights[c], A, G, determinants, ratios) >= 1.0:
            continue
        for q in range(points):
            for a in range(nodes):
                for i in range(3):
                    vectors[q, 3 * a + i] = (
                        G[3 * i, q] * gradients[a, 0, q]
                        + G[3 * i + 1, q] * gradients[a, 1, q]
                        + G[3 * i + 2, q] * gradients[a, 2, q]
                    )
        slopes[:] = 0.0
        curvatures[:] = 0.0
        for i in range(len(form)):
            if ratios[i] < 1.0:
                _, slope, curvature = barrier(ratios[i])
                for q in range(points):
                    slopes[q] += weights[c] * slope / heights[c, i] * form[i, q]
                    for p in range(points):
                        curvatures[q, p] += weights[c] * curvature / heights[c, i] ** 2 * form[i, q] * form[i, p]
        for q in range(points):
            turn = 0.0 if project else slopes[q] / determinants[q]
            curvatures[q, q] += turn
            for r in range(3 * nodes):
                scaled[q, r] = turn * vectors[q, r]
        np.dot(vectors.T, scaled, T)
        np.dot(curvatures, vectors, scaled)
        np.dot(vectors.T, scaled, K)
        _scatter(K, T, scatter[e], values)
