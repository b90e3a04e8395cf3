"""Determinants at the watched points, and the step that raises the smallest of them."""

from __future__ import annotations

import numba
import numpy as np

from risorius.mechanics.point import cofactor

_compiled = numba.njit(cache=True, error_model="numpy")


@_compiled
def smallest_determinant(change, jacobians):  # type: ignore[no-untyped-def]
    """Write J (k,) of deformation gradients less identity (9 k,), row by row; return the smallest, NaN where one is."""
    smallest = np.inf
    for p in range(len(jacobians)):
        c = change[9 * p : 9 * p + 9]
        xx, yy, zz = 1.0 + c[0], 1.0 + c[4], 1.0 + c[8]
        J = xx * (yy * zz - c[5] * c[7]) + c[1] * (c[5] * c[6] - c[3] * zz) + c[2] * (c[3] * c[7] - yy * c[6])
        jacobians[p] = J
        if not smallest <= J:
            smallest = J
    return smallest


@_compiled
def push(change, jacobians, slopes, wanted, longest, direction, modal):  # type: ignore[no-untyped-def]
    """Change modal coordinates (m,) so that, to first order, the smallest J becomes `wanted`: by the least change.

    slopes (k, 9, m): of the deformation gradients; direction (m,): working space; longest: of the change.
    """
    worst = np.argmin(jacobians)
    F, G = np.empty(9), np.empty(9)
    for i in range(9):
        F[i] = change[9 * worst + i]
    for i in range(0, 9, 4):
        F[i] += 1.0
    J = cofactor(F, G)
    direction[:] = 0.0
    for i in range(9):
        for k in range(len(direction)):
            direction[k] += G[i] * slopes[worst, i, k]
    size = 0.0
    for k in range(len(direction)):
        size += direction[k] * direction[k]
    if size > 0.0:
        step = min((wanted - J) / size, longest / size**0.5)
        for k in range(len(direction)):
            modal[k] += step * direction[k]
