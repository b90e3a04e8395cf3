"""Directions in which the energy density of a point is not convex, for the projection of element tangents.

Without active stress the density is psi(I1, J). With F = U diag(s) V^T the nine eigenvectors of d2 psi / dF dF are
U M V^T with M and eigenvalues (Smith, de Goes and Kim 2019, Analytic eigensystems for isotropic distortion energies;
i, j, k is each cyclic order of the axes)

    twists     (e_i e_j^T - e_j e_i^T) / sqrt 2     2 psi_1 + psi_J s_k
    flips      (e_i e_j^T + e_j e_i^T) / sqrt 2     2 psi_1 - psi_J s_k
    stretches  diag(e)                              those of 2 psi_1 I + 4 psi_11 s s^T + psi_JJ g g^T + psi_J S

with g_i = s_j s_k, S_ij = s_k off the diagonal and 0 on it. Tensors are rows, as in `point`.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from risorius.mechanics.point import add_active_tangent, add_cofactor_derivative

_compiled = numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz", "arcp", "reassoc"})

# Squared cosine below which two columns are orthogonal; sweeps converge quadratically, and seldom five are needed.
_ORTHOGONAL = 1e-28
_MOST_SWEEPS = 16


@_compiled
def orthogonalise(B, V):  # type: ignore[no-untyped-def]
    """Write a rotation V and turn B into B V with orthogonal columns (one-sided Jacobi, Hestenes 1958); both (9,)."""
    V[:] = 0.0
    V[0] = V[4] = V[8] = 1.0
    for _ in range(_MOST_SWEEPS):
        turned = False
        for p in range(2):
            for q in range(p + 1, 3):
                pp = B[p] * B[p] + B[p + 3] * B[p + 3] + B[p + 6] * B[p + 6]
                qq = B[q] * B[q] + B[q + 3] * B[q + 3] + B[q + 6] * B[q + 6]
                pq = B[p] * B[q] + B[p + 3] * B[q + 3] + B[p + 6] * B[q + 6]
                if pq * pq <= _ORTHOGONAL * pp * qq:
                    continue
                turned = True
                gap = qq - pp
                tangent = 2.0 * pq / (gap + math.copysign(math.sqrt(gap * gap + 4.0 * pq * pq), gap))
                cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
                sine = cosine * tangent
                for r in (0, 3, 6):
                    x, y = B[r + p], B[r + q]
                    B[r + p], B[r + q] = cosine * x - sine * y, sine * x + cosine * y
                    x, y = V[r + p], V[r + q]
                    V[r + p], V[r + q] = cosine * x - sine * y, sine * x + cosine * y
        if not turned:
            return


@_compiled
def _singular_values(F, U, s, V):  # type: ignore[no-untyped-def]
    """Write F = U diag(s) V^T for det F > 0, in no order."""
    U[:] = F
    orthogonalise(U, V)
    for k in range(3):
        s[k] = math.sqrt(U[k] * U[k] + U[k + 3] * U[k + 3] + U[k + 6] * U[k + 6])
        for r in (0, 3, 6):
            U[r + k] /= s[k]


@_compiled
def _stretch_matrix(s, shear, stretch, slope, curvature, A):  # type: ignore[no-untyped-def]
    """Write the (9,) matrix whose eigenvectors are the stretches."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        A[4 * i] = shear + stretch * s[i] * s[i] + curvature * (s[j] * s[k]) ** 2
        A[3 * i + j] = s[k] * (slope + curvature * s[0] * s[1] * s[2]) + stretch * s[i] * s[j]
        A[3 * j + i] = A[3 * i + j]


@_compiled
def _above(A, floor):  # type: ignore[no-untyped-def]
    """Whether the eigenvalues of the symmetric A (9,) are above `floor`, by Sylvester's criterion."""
    a, b, c = A[0] - floor, A[4] - floor, A[8] - floor
    minor = a * b - A[1] * A[1]
    return a > 0.0 and minor > 0.0 and minor * c + 2.0 * A[1] * A[2] * A[5] > a * A[5] * A[5] + b * A[2] * A[2]


@_compiled
def _write_pair(U, V, i, j, sign, mode):  # type: ignore[no-untyped-def]
    """Write the flip (sign 1) or twist (sign -1) of the axes i and j."""
    half = math.sqrt(0.5)
    for r in range(3):
        for c in range(3):
            mode[3 * r + c] = half * (U[3 * r + i] * V[3 * c + j] + sign * U[3 * r + j] * V[3 * c + i])


@_compiled
def _write_stretch(U, V, E, k, mode):  # type: ignore[no-untyped-def]
    """Write U diag(e) V^T with the column k of E as e."""
    for r in range(3):
        for c in range(3):
            mode[3 * r + c] = 0.0
            for i in range(3):
                mode[3 * r + c] += U[3 * r + i] * E[3 * i + k] * V[3 * c + i]


@_compiled
def isotropic_modes_below(F, shear, stretch, slope, curvature, floor, modes, lifts, work):  # type: ignore[no-untyped-def]
    """Eigenvectors of d2 psi / dF dF with eigenvalues below `floor`: their number m, modes[:m] (9,), lifts[:m].

    shear = 2 psi_1, stretch = 4 psi_11, slope = psi_J, curvature = psi_JJ; det F > 0. A lift is what the eigenvalue
    lacks of `floor`. work (5, 9) is working space.
    """
    U, s, V, A, E = work[0], work[1], work[2], work[3], work[4]
    _singular_values(F, U, s, V)
    count = 0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        for sign in (-1.0, 1.0):
            value = shear - sign * slope * s[k]
            if value < floor:
                _write_pair(U, V, i, j, sign, modes[count])
                lifts[count] = floor - value
                count += 1
    _stretch_matrix(s, shear, stretch, slope, curvature, A)
    if _above(A, floor):
        return count
    # The shift makes A positive definite, so that its singular values are its eigenvalues.
    shift = 2.0 * np.abs(A).sum()
    for i in range(3):
        A[4 * i] += shift
    orthogonalise(A, E)
    for k in range(3):
        value = math.sqrt(A[k] * A[k] + A[k + 3] * A[k + 3] + A[k + 6] * A[k + 6]) - shift
        if value < floor:
            _write_stretch(U, V, E, k, modes[count])
            lifts[count] = floor - value
            count += 1
    return count


@_compiled
def positive(H, L, floor):  # type: ignore[no-untyped-def]
    """Whether H - floor I has a Cholesky factor; L is working space."""
    n = H.shape[0]
    for j in range(n):
        s = H[j, j] - floor
        for k in range(j):
            s -= L[j, k] * L[j, k]
        if s <= 0.0:
            return False
        L[j, j] = math.sqrt(s)
        for i in range(j + 1, n):
            t = H[i, j]
            for k in range(j):
                t -= L[i, k] * L[j, k]
            L[i, j] = t / L[j, j]
    return True


@_compiled
def modes_below(F, G, shear, stretch, slope, curvature, active, floor, modes, lifts, work):  # type: ignore[no-untyped-def]
    """As `isotropic_modes_below`, for the sum of psi and tr(F A F^T) / 2 with the positive semi-definite A = `active`.

    G = cof F. Active stress makes up for much of what psi lacks: lifting psi alone takes many more Newton steps.
    Only where it does not make up for all is there an eigenproblem without a closed form.
    """
    count = isotropic_modes_below(F, shear, stretch, slope, curvature, floor, modes, lifts, work)
    if count == 0 or np.abs(active).max() == 0.0:
        return count
    H = np.empty((9, 9))
    for i in range(9):
        for j in range(9):
            H[i, j] = stretch * F[i] * F[j] + curvature * G[i] * G[j]
        H[i, i] += shear
    add_cofactor_derivative(H, F, slope)
    add_active_tangent(H, active)
    if positive(H, np.empty((9, 9)), floor):
        return 0
    values, vectors = np.linalg.eigh(H)
    count = 0
    while count < 9 and values[count] < floor:
        modes[count] = vectors[:, count]
        lifts[count] = floor - values[count]
        count += 1
    return count
