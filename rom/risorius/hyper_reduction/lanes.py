"""Kernels with elements side by side in vector lanes: arrays have the element last and loops run along it.

e elements with a nodes; tensors are rows, as in `mechanics.point`.
"""

from __future__ import annotations

import math

import numba

compiled = numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz", "arcp", "reassoc"})

# Logarithms and barriers go on to second order below this part of the volume at rest, so that every displacement has an
# energy, forces and stiffness. Muscles squeeze hardly any tissue so far: what lies beyond need only be stable.
FLOOR = 0.05


@compiled
def relaxed_log(J):  # type: ignore[no-untyped-def]
    """ln J, continued to second order below FLOOR."""
    bounded = max(J, FLOOR)
    x = (J - bounded) / bounded
    return math.log(bounded) + x - 0.5 * x * x


@compiled
def relaxed_log_slopes(J):  # type: ignore[no-untyped-def]
    """First and second derivative of `relaxed_log`."""
    bounded = max(J, FLOOR)
    return (2.0 * bounded - J) / (bounded * bounded), -1.0 / (bounded * bounded)


@compiled
def gradient_at(u, slopes, F):  # type: ignore[no-untyped-def]
    """Write the gradient (9, e) at one point of a displacement u (3 a, e), with slopes (3 a, e) of shape functions."""
    F[:] = 0.0
    for a in range(0, len(u), 3):
        for i in range(3):
            for j in range(3):
                row, displacement, slope = F[3 * i + j], u[a + i], slopes[a + j]
                for e in range(len(row)):
                    row[e] += displacement[e] * slope[e]


@compiled
def cofactors(F, G, J):  # type: ignore[no-untyped-def]
    """Write cof F (9, e) and det F (e,)."""
    for i in range(3):
        k, m = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            p, n = (j + 1) % 3, (j + 2) % 3
            row, a, b, c, d = G[3 * i + j], F[3 * k + p], F[3 * m + n], F[3 * k + n], F[3 * m + p]
            for e in range(len(row)):
                row[e] = a[e] * b[e] - c[e] * d[e]
    for e in range(len(J)):
        J[e] = F[0, e] * G[0, e] + F[1, e] * G[1, e] + F[2, e] * G[2, e]


@compiled
def cofactor_changes(F, D, C):  # type: ignore[no-untyped-def]
    """Write the change (9, e) of cof F that a change D of F makes."""
    for i in range(3):
        k, m = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            p, n = (j + 1) % 3, (j + 2) % 3
            row = C[3 * i + j]
            a, b, c, d = F[3 * k + p], F[3 * m + n], F[3 * k + n], F[3 * m + p]
            da, db, dc, dd = D[3 * k + p], D[3 * m + n], D[3 * k + n], D[3 * m + p]
            for e in range(len(row)):
                row[e] = da[e] * b[e] + a[e] * db[e] - dc[e] * d[e] - c[e] * dd[e]


@compiled
def contract(A, B, out):  # type: ignore[no-untyped-def]
    """Write A : B (e,) of tensors (9, e)."""
    out[:] = 0.0
    for k in range(9):
        for e in range(len(out)):
            out[e] += A[k, e] * B[k, e]


@compiled
def add_divergence(P, slopes, forces):  # type: ignore[no-untyped-def]
    """Add the forces (3 a, e) of stresses P (9, e) that are weighted with the volume of a point."""
    for a in range(0, len(forces), 3):
        for i in range(3):
            row = forces[a + i]
            for j in range(3):
                stress, slope = P[3 * i + j], slopes[a + j]
                for e in range(len(row)):
                    row[e] += stress[e] * slope[e]
