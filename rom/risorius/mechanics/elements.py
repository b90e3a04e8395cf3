"""Integration of energy, nodal forces and tangent over elements; one kernel for every element type.

Energy of an element: sum over its points of w (psi(I1, J) + T/2 |F a0|^2) plus, with mean dilatation, V U(Jbar) with
V Jbar = sum w J (Nagtegaal, Parks and Rice 1974; Simo, Taylor and Pister 1985). Without it U is taken point by point.

Arrays: u (n, 3) displacement, connectivity (e, a), gradients (e, q, a, 3) of the shape functions, weights (e, q)
volumes, coefficients (e, 3) = (c10, c20, lam), active (e, q, 6) = T a0 (x) a0 as (xx, yy, zz, xy, yz, zx).
All in SI units, C order. `forces` (n, 3) is added to.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from risorius.mechanics.point import (
    active_stress,
    barrier,
    cofactor,
    isochoric,
    volumetric,
)
from risorius.mechanics.projection import modes_below

_compiled = numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz", "arcp", "reassoc"})

# An element tangent is projected at points where its 9 x 9 density is not positive; this is the floor, relative to c10.
PROJECTION_FLOOR = 1e-6


@_compiled
def _deformation(u, connectivity, gradients, weights, e, F, G, jacobian):  # type: ignore[no-untyped-def]
    """Deformation gradient, cofactor and J at the points of element e; returns (volume, mean J, smallest J)."""
    volume = 0.0
    mean = 0.0
    smallest = math.inf
    for q in range(weights.shape[1]):
        # In scalars, which stay in registers.
        xx, xy, xz, yx, yy, yz, zx, zy, zz = 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0
        for a in range(connectivity.shape[1]):
            node = connectivity[e, a]
            x, y, z = u[node, 0], u[node, 1], u[node, 2]
            dx, dy, dz = gradients[e, q, a, 0], gradients[e, q, a, 1], gradients[e, q, a, 2]
            xx, xy, xz = xx + x * dx, xy + x * dy, xz + x * dz
            yx, yy, yz = yx + y * dx, yy + y * dy, yz + y * dz
            zx, zy, zz = zx + z * dx, zy + z * dy, zz + z * dz
        Fq = F[q]
        Fq[0], Fq[1], Fq[2], Fq[3], Fq[4], Fq[5], Fq[6], Fq[7], Fq[8] = xx, xy, xz, yx, yy, yz, zx, zy, zz
        jacobian[q] = cofactor(Fq, G[q])
        volume += weights[e, q]
        mean += weights[e, q] * jacobian[q]
        smallest = min(smallest, jacobian[q])
    return volume, mean / volume, smallest


@_compiled
def _dilatation(lam, volume, mean, mean_dilatation):  # type: ignore[no-untyped-def]
    """Energy, pressure and stiffness that are common to the element; zeros without mean dilatation."""
    if not mean_dilatation:
        return 0.0, 0.0, 0.0
    energy, pressure, stiffness = volumetric(lam, mean)
    return volume * energy, pressure, stiffness / volume


@_compiled
def energy_and_forces(  # type: ignore[no-untyped-def]
    u, connectivity, gradients, weights, coefficients, active, mean_dilatation, with_forces, forces
):
    """Energy (J) and smallest J of all elements; adds the internal and active nodal forces (N) to `forces`.

    An element with J <= 0 at a point has infinite energy, and no forces are added for it.
    """
    points = weights.shape[1]
    F, G = np.empty((points, 9)), np.empty((points, 9))
    jacobian, P = np.empty(points), np.empty(9)
    total = 0.0
    smallest = math.inf
    for e in range(connectivity.shape[0]):
        c10, c20, lam = coefficients[e, 0], coefficients[e, 1], coefficients[e, 2]
        volume, mean, lowest = _deformation(u, connectivity, gradients, weights, e, F, G, jacobian)
        smallest = min(smallest, lowest)
        if lowest <= 0.0:
            total = math.inf
            continue
        energy, pressure, _ = _dilatation(lam, volume, mean, mean_dilatation)
        total += energy
        for q in range(points):
            w = weights[e, q]
            i1 = 0.0
            for i in range(9):
                i1 += F[q, i] * F[q, i]
            psi, dpsi, _ = isochoric(c10, c20, i1)
            wall, dwall, _ = barrier(c10, jacobian[q])
            slope = dwall + pressure
            psi += wall + active_stress(F[q], active[e, q], P)
            if not mean_dilatation:
                local, dlocal, _ = volumetric(lam, jacobian[q])
                psi += local
                slope += dlocal
            total += w * psi
            if with_forces:
                for i in range(9):
                    P[i] = w * (P[i] + 2.0 * dpsi * F[q, i] + slope * G[q, i])
                xx, xy, xz, yx, yy, yz, zx, zy, zz = P[0], P[1], P[2], P[3], P[4], P[5], P[6], P[7], P[8]
                for a in range(connectivity.shape[1]):
                    node = connectivity[e, a]
                    dx, dy, dz = gradients[e, q, a, 0], gradients[e, q, a, 1], gradients[e, q, a, 2]
                    forces[node, 0] += xx * dx + xy * dy + xz * dz
                    forces[node, 1] += yx * dx + yy * dy + yz * dz
                    forces[node, 2] += zx * dx + zy * dy + zz * dz
    return total, smallest


@_compiled
def _derivatives(c10, c20, lam, F, jacobian, pressure, local):  # type: ignore[no-untyped-def]
    """2 psi_1, 4 psi_11, psi_J and psi_JJ with the element's pressure; `local` takes U at the point instead."""
    i1 = 0.0
    for i in range(9):
        i1 += F[i] * F[i]
    _, dpsi, ddpsi = isochoric(c10, c20, i1)
    _, slope, curvature = barrier(c10, jacobian)
    if local:
        _, pressure, bulk = volumetric(lam, jacobian)
        curvature += bulk
    return 2.0 * dpsi, 4.0 * ddpsi, slope + pressure, curvature


@_compiled
def _append(T, gradient, factor, vectors, scaled, row):  # type: ignore[no-untyped-def]
    """Write v = T grad N_a, node by node, into a row of `vectors` (m, 3 a) and factor v into that of `scaled`."""
    for a in range(gradient.shape[0]):
        x, y, z = gradient[a, 0], gradient[a, 1], gradient[a, 2]
        for i in range(3):
            v = T[3 * i] * x + T[3 * i + 1] * y + T[3 * i + 2] * z
            vectors[row, 3 * a + i] = v
            scaled[row, 3 * a + i] = factor * v
    return row + 1


@_compiled
def _append_mean(weights, factor, vectors, scaled, row):  # type: ignore[no-untyped-def]
    """As `_append`, with the weighted sum of the first rows of `vectors`."""
    for r in range(vectors.shape[1]):
        v = 0.0
        for q in range(len(weights)):
            v += weights[q] * vectors[q, r]
        vectors[row, r] = v
        scaled[row, r] = factor * v
    return row + 1


@_compiled
def _add_shear(gradient, w, shear, A, S):  # type: ignore[no-untyped-def]
    """Add w grad N_a . (shear I + A) grad N_b to S (a, a)."""
    xx, yy, zz = w * (shear + A[0]), w * (shear + A[1]), w * (shear + A[2])
    xy, yz, zx = w * A[3], w * A[4], w * A[5]
    for a in range(gradient.shape[0]):
        x, y, z = gradient[a, 0], gradient[a, 1], gradient[a, 2]
        hx, hy, hz = xx * x + xy * y + zx * z, xy * x + yy * y + yz * z, zx * x + yz * y + zz * z
        for b in range(gradient.shape[0]):
            S[a, b] += hx * gradient[b, 0] + hy * gradient[b, 1] + hz * gradient[b, 2]


@_compiled
def _scatter(K, T, S, positions, values):  # type: ignore[no-untyped-def]
    """Add K + S (x) I minus T with the components of its two nodes exchanged to the stored entries of a matrix."""
    nodes = S.shape[0]
    for a in range(nodes):
        for i in range(3):
            for b in range(nodes):
                for j in range(3):
                    position = positions[3 * a + i, 3 * b + j]
                    if position >= 0:
                        values[position] += K[3 * a + i, 3 * b + j] - T[3 * a + j, 3 * b + i]
                        if i == j:
                            values[position] += S[a, b]


@_compiled
def tangent(  # type: ignore[no-untyped-def]
    u, connectivity, gradients, weights, coefficients, active, mean_dilatation, project, scatter, values
):
    """Add the element tangents (N/m) at an admissible u (J > 0) to `values`, the entries of a sparse matrix.

    scatter (e, 3 a, 3 a): position in `values` of every entry, -1 for entries that are not stored (the other
    triangle). `project` makes every element tangent positive semi-definite.

    With f_a = F grad N_a and g_a = cof F grad N_a, the block of nodes a and b is the sum over points of

        w (grad N_a . (2 psi_1 I + A) grad N_b I + 4 psi_11 f_a f_b^T + psi_JJ g_a g_b^T
           + psi_J / J (g_a g_b^T - g_b g_a^T))

    All terms c v v^T, also those of the projection and of the mean dilatation, make one matrix product.
    """
    nodes, points = connectivity.shape[1], weights.shape[1]
    F, G, jacobian = np.empty((points, 9)), np.empty((points, 9)), np.empty(points)
    # Rows: g and f of every point, at most nine modes of every point, the mean of g.
    vectors, scaled = np.empty((11 * points + 1, 3 * nodes)), np.empty((11 * points + 1, 3 * nodes))
    exchanged = np.empty((points, 3 * nodes))
    K, T, S = np.empty((3 * nodes, 3 * nodes)), np.empty((3 * nodes, 3 * nodes)), np.empty((nodes, nodes))
    modes, lifts, work = np.empty((9, 9)), np.empty(9), np.empty((5, 9))
    for e in range(connectivity.shape[0]):
        c10, c20, lam = coefficients[e, 0], coefficients[e, 1], coefficients[e, 2]
        volume, mean, _ = _deformation(u, connectivity, gradients, weights, e, F, G, jacobian)
        _, pressure, stiffness = _dilatation(lam, volume, mean, mean_dilatation)
        # With one point the dilatational term belongs to the point: projecting the sum is less stiff.
        at_point = stiffness * volume if points == 1 else 0.0
        S[:] = 0.0
        rows = points
        for q in range(points):
            w, gradient, A = weights[e, q], gradients[e, q], active[e, q]
            local = not mean_dilatation
            shear, stretch, slope, curvature = _derivatives(c10, c20, lam, F[q], jacobian[q], pressure, local)
            curvature += at_point
            turn = slope / jacobian[q]
            _append(G[q], gradient, w * (curvature + turn), vectors, scaled, q)
            _add_shear(gradient, w, shear, A, S)
            for r in range(3 * nodes):
                exchanged[q, r] = w * turn * vectors[q, r]
            if stretch != 0.0:
                rows = _append(F[q], gradient, w * stretch, vectors, scaled, rows)
            if project:
                floor = PROJECTION_FLOOR * c10
                count = modes_below(F[q], G[q], shear, stretch, slope, curvature, A, floor, modes, lifts, work)
                for k in range(count):
                    rows = _append(modes[k], gradient, w * lifts[k], vectors, scaled, rows)
        if points > 1 and stiffness != 0.0:
            rows = _append_mean(weights[e], stiffness, vectors, scaled, rows)
        np.dot(vectors[:rows].T, scaled[:rows], K)
        np.dot(vectors[:points].T, exchanged, T)
        _scatter(K, T, S, scatter[e], values)
