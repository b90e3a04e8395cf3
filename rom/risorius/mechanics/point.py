"""Scalars and small tensors of one material point, in numba. Tensors are rows: F[3 i + j] = F_ij."""

from __future__ import annotations

import math

import numba

inlined = numba.njit(inline="always", error_model="numpy")


@inlined
def isochoric(c10, c20, i1):  # type: ignore[no-untyped-def]
    """Energy of I1 and its first and second derivative."""
    x = i1 - 3.0
    return c10 * x + c20 * x * x, c10 + 2.0 * c20 * x, 2.0 * c20


@inlined
def barrier(c10, jacobian):  # type: ignore[no-untyped-def]
    """-2 c10 ln J and its first and second derivative; infinite for J <= 0."""
    if jacobian <= 0.0:
        return math.inf, 0.0, 0.0
    return -2.0 * c10 * math.log(jacobian), -2.0 * c10 / jacobian, 2.0 * c10 / (jacobian * jacobian)


@inlined
def volumetric(lam, jacobian):  # type: ignore[no-untyped-def]
    """lam/2 (ln J)^2 and its first and second derivative; infinite for J <= 0."""
    if jacobian <= 0.0:
        return math.inf, 0.0, 0.0
    log = math.log(jacobian)
    return 0.5 * lam * log * log, lam * log / jacobian, lam * (1.0 - log) / (jacobian * jacobian)


@inlined
def cofactor(F, G):  # type: ignore[no-untyped-def]
    """Write cof F = dJ/dF into G and return J = det F."""
    G[0] = F[4] * F[8] - F[5] * F[7]
    G[1] = F[5] * F[6] - F[3] * F[8]
    G[2] = F[3] * F[7] - F[4] * F[6]
    G[3] = F[2] * F[7] - F[1] * F[8]
    G[4] = F[0] * F[8] - F[2] * F[6]
    G[5] = F[1] * F[6] - F[0] * F[7]
    G[6] = F[1] * F[5] - F[2] * F[4]
    G[7] = F[2] * F[3] - F[0] * F[5]
    G[8] = F[0] * F[4] - F[1] * F[3]
    return F[0] * G[0] + F[1] * G[1] + F[2] * G[2]


@inlined
def add_cofactor_derivative(H, F, s):  # type: ignore[no-untyped-def]
    """Add s d(cof F)/dF to the symmetric (9, 9) matrix H: entry (ij, kl) is s eps_ikm eps_jln F_mn."""
    for i in range(3):
        k, m = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            p, n = (j + 1) % 3, (j + 2) % 3
            row = 3 * i + j
            H[row, 3 * k + p] += s * F[3 * m + n]
            H[row, 3 * m + n] += s * F[3 * k + p]
            H[row, 3 * k + n] -= s * F[3 * m + p]
            H[row, 3 * m + p] -= s * F[3 * k + n]


@inlined
def active_stress(F, A, P):  # type: ignore[no-untyped-def]
    """Write P = F A for the symmetric A = (xx, yy, zz, xy, yz, zx) and return the energy density tr(F A F^T) / 2."""
    energy = 0.0
    for i in range(3):
        x, y, z = F[3 * i], F[3 * i + 1], F[3 * i + 2]
        P[3 * i] = x * A[0] + y * A[3] + z * A[5]
        P[3 * i + 1] = x * A[3] + y * A[1] + z * A[4]
        P[3 * i + 2] = x * A[5] + y * A[4] + z * A[2]
        energy += 0.5 * (x * P[3 * i] + y * P[3 * i + 1] + z * P[3 * i + 2])
    return energy


@inlined
def add_active_tangent(H, A):  # type: ignore[no-untyped-def]
    """Add dP/dF of `active_stress` to the (9, 9) matrix H."""
    for b in (0, 3, 6):
        H[b, b] += A[0]
        H[b + 1, b + 1] += A[1]
        H[b + 2, b + 2] += A[2]
        H[b, b + 1] += A[3]
        H[b + 1, b] += A[3]
        H[b + 1, b + 2] += A[4]
        H[b + 2, b + 1] += A[4]
        H[b, b + 2] += A[5]
        H[b + 2, b] += A[5]
