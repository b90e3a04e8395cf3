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
    add_active_tangent,
    add_cofactor_derivative,
    barrier,
    cofactor,
    isochoric,
    volumetric,
)

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
        Fq = F[q]
        Fq[:] = 0.0
        for a in range(connectivity.shape[1]):
            node = connectivity[e, a]
            for i in range(3):
                for j in range(3):
                    Fq[3 * i + j] += u[node, i] * gradients[e, q, a, j]
        for i in range(3):
            Fq[4 * i] += 1.0
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
                for a in range(connectivity.shape[1]):
                    node = connectivity[e, a]
                    for i in range(3):
                        forces[node, i] += (
                            P[3 * i] * gradients[e, q, a, 0]
                            + P[3 * i + 1] * gradients[e, q, a, 1]
                            + P[3 * i + 2] * gradients[e, q, a, 2]
                        )
    return total, smallest


@_compiled
def _positive(H, L, shift):  # type: ignore[no-untyped-def]
    """Whether H + shift I has a Cholesky factor; L is working space."""
    for j in range(9):
        s = H[j, j] + shift
        for k in range(j):
            s -= L[j, k] * L[j, k]
        if s <= 0.0:
            return False
        L[j, j] = math.sqrt(s)
        for i in range(j + 1, 9):
            t = H[i, j]
            for k in range(j):
                t -= L[i, k] * L[j, k]
            L[i, j] = t / L[j, j]
    return True


@_compiled
def _project(H, L, floor):  # type: ignore[no-untyped-def]
    """Raise the eigenvalues of H to `floor` where they are below (Teran et al. 2005)."""
    if _positive(H, L, -floor):
        return
    values, vectors = np.linalg.eigh(H)
    for i in range(9):
        for j in range(9):
            s = 0.0
            for k in range(9):
                s += vectors[i, k] * max(values[k], floor) * vectors[j, k]
            H[i, j] = s


@_compiled
def _point_tangent(F, G, jacobian, c10, c20, lam, pressure, active, local_stiffness, local, H):  # type: ignore[no-untyped-def]
    """d2 psi / dF dF (9, 9) at a point, with the element's pressure; `local` takes U at the point instead."""
    i1 = 0.0
    for i in range(9):
        i1 += F[i] * F[i]
    _, dpsi, ddpsi = isochoric(c10, c20, i1)
    _, slope, curvature = barrier(c10, jacobian)
    slope += pressure
    curvature += local_stiffness
    if local:
        _, dlocal, ddlocal = volumetric(lam, jacobian)
        slope += dlocal
        curvature += ddlocal
    for i in range(9):
        for j in range(9):
            H[i, j] = 4.0 * ddpsi * F[i] * F[j] + curvature * G[i] * G[j]
        H[i, i] += 2.0 * dpsi
    add_cofactor_derivative(H, F, slope)
    add_active_tangent(H, active)


@_compiled
def _add_point(K, H, HB, gradient, w, nodes):  # type: ignore[no-untyped-def]
    """Add w B^T H B of one point to the upper triangle, by node, of the element matrix K; HB is working space."""
    for b in range(nodes):
        x, y, z = w * gradient[b, 0], w * gradient[b, 1], w * gradient[b, 2]
        for row in range(9):
            for k in range(3):
                HB[row, 3 * b + k] = H[row, 3 * k] * x + H[row, 3 * k + 1] * y + H[row, 3 * k + 2] * z
    for a in range(nodes):
        x, y, z = gradient[a, 0], gradient[a, 1], gradient[a, 2]
        for i in range(3):
            for c in range(3 * a, 3 * nodes):
                K[3 * a + i, c] += x * HB[3 * i, c] + y * HB[3 * i + 1, c] + z * HB[3 * i + 2, c]


@_compiled
def tangent(  # type: ignore[no-untyped-def]
    u, connectivity, gradients, weights, coefficients, active, mean_dilatation, project, scatter, values
):
    """Add the element tangents (N/m) at an admissible u (J > 0) to `values`, the entries of a sparse matrix.

    scatter (e, 3 a, 3 a): position in `values` of every entry, -1 for entries that are not stored (the other
    triangle). `project` makes every element tangent positive semi-definite.
    """
    nodes, points = connectivity.shape[1], weights.shape[1]
    F, G, jacobian = np.empty((points, 9)), np.empty((points, 9)), np.empty(points)
    H, L, HB = np.empty((9, 9)), np.empty((9, 9)), np.empty((9, 3 * nodes))
    K, mean_gradient = np.empty((3 * nodes, 3 * nodes)), np.empty(3 * nodes)
    for e in range(connectivity.shape[0]):
        c10, c20, lam = coefficients[e, 0], coefficients[e, 1], coefficients[e, 2]
        volume, mean, _ = _deformation(u, connectivity, gradients, weights, e, F, G, jacobian)
        _, pressure, stiffness = _dilatation(lam, volume, mean, mean_dilatation)
        # With one point the dilatational term belongs to the point: projecting the sum is less stiff.
        at_point = stiffness * volume if points == 1 else 0.0
        K[:] = 0.0
        mean_gradient[:] = 0.0
        for q in range(points):
            w = weights[e, q]
            _point_tangent(
                F[q], G[q], jacobian[q], c10, c20, lam, pressure, active[e, q], at_point, not mean_dilatation, H
            )
            if project:
                _project(H, L, PROJECTION_FLOOR * c10)
            _add_point(K, H, HB, gradients[e, q], w, nodes)
            for a in range(nodes):
                for i in range(3):
                    for j in range(3):
                        mean_gradient[3 * a + i] += w * G[q, 3 * i + j] * gradients[e, q, a, j]
        if points > 1 and stiffness != 0.0:
            for r in range(3 * nodes):
                for c in range(r, 3 * nodes):
                    K[r, c] += stiffness * mean_gradient[r] * mean_gradient[c]
        for r in range(3 * nodes):
            for c in range(3 * nodes):
                position = scatter[e, r, c]
                if position >= 0:
                    values[position] += K[r, c] if c // 3 >= r // 3 else K[c, r]
