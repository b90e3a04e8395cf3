"""Passive tissue, as in `mechanics.elements` with mean dilatation, in vector lanes and with relaxed logarithms."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from risorius.hyper_reduction.lanes import (
    add_divergence,
    cofactor_changes,
    cofactors,
    compiled,
    contract,
    gradient_at,
    relaxed_log,
    relaxed_log_slopes,
)
from risorius.hyper_reduction.terms import Floats
from risorius.mechanics.body import PassiveElements


class Tissue:
    """Elements of one kind with a state: at rest at first. Forces and products are overwritten by the next call.

    dtype: floating type of all arrays.
    """

    def __init__(self, elements: PassiveElements, dtype: npt.DTypeLike = np.float64) -> None:
        count, points, nodes, _ = elements.gradients.shape
        self.connectivity = elements.connectivity
        gradients = elements.gradients.reshape(count, points, 3 * nodes).transpose(1, 2, 0)
        self._gradients = np.ascontiguousarray(gradients, dtype)
        self._weights = np.ascontiguousarray(elements.weights.T, dtype)
        self._coefficients = np.ascontiguousarray(elements.coefficients.T, dtype)
        self._F, self._G = np.empty((points, 9, count), dtype), np.empty((points, 9, count), dtype)
        self._J, self._slopes = np.empty((points, count), dtype), np.empty((points, count), dtype)
        self._mean, self._bulk = np.empty(count, dtype), np.empty(count, dtype)
        self._work = np.empty((points, 9, count), dtype), np.empty((9, count), dtype), np.empty((3, count), dtype)
        self._changes = np.empty((points, count), dtype)
        self._forces = np.empty((3 * nodes, count), dtype)

    def deform(self, u: Floats) -> None:
        """Take the displacement (3 a, e) of the nodes of every element, metres."""
        tables = self._gradients, self._weights, self._coefficients
        _deform(u, *tables, self._F, self._G, self._J, self._mean, self._slopes, self._bulk)

    def energy(self) -> float:
        """Joules."""
        return float(_energy(self._F, self._J, self._mean, self._weights, self._coefficients))

    def forces(self) -> Floats:
        """Derivatives (3 a, e) of the energy by the displacement, newtons."""
        tables = self._gradients, self._weights, self._coefficients
        _add_forces(self._F, self._G, self._slopes, *tables, *self._work[1:], self._forces)
        return self._forces

    def product(self, v: Floats) -> Floats:
        """Change (3 a, e) of the forces with a change v (3 a, e) of the displacement."""
        state = self._F, self._G, self._J, self._slopes, self._bulk
        tables = self._gradients, self._weights, self._coefficients
        _product(v, *state, *tables, *self._work, self._changes, self._forces)
        return self._forces

    def smallest_jacobian(self) -> float:
        """Smallest J at the points."""
        return float(self._J.min(initial=np.inf))


@compiled
def _deform(u, gradients, weights, coefficients, F, G, J, mean, slopes, bulk):  # type: ignore[no-untyped-def]
    """Write F, G = cof F (q, 9, e), J (q, e), its mean (e,), psi_J (q, e), and U'' of the mean over the volume (e,)."""
    c10, lam = coefficients[0], coefficients[2]
    mean[:] = 0.0
    bulk[:] = 0.0  # the volume, for the time being
    for q in range(len(weights)):
        gradient_at(u, gradients[q], F[q])
        for i in range(0, 9, 4):
            for e in range(len(mean)):
                F[q, i, e] += 1.0
        cofactors(F[q], G[q], J[q])
        for e in range(len(mean)):
            bulk[e] += weights[q, e]
            mean[e] += weights[q, e] * J[q, e]
    for e in range(len(mean)):
        volume = bulk[e]
        mean[e] /= volume
        log = relaxed_log(mean[e])
        first, second = relaxed_log_slopes(mean[e])
        bulk[e] = lam[e] * (first * first + log * second) / volume
        for q in range(len(weights)):
            slopes[q, e] = lam[e] * log * first
    for q in range(len(weights)):
        for e in range(len(mean)):
            slopes[q, e] -= 2.0 * c10[e] * relaxed_log_slopes(J[q, e])[0]


@compiled
def _energy(F, J, mean, weights, coefficients):  # type: ignore[no-untyped-def]
    total = 0.0
    for e in range(len(mean)):
        c10, c20, lam = coefficients[0, e], coefficients[1, e], coefficients[2, e]
        volume = 0.0
        for q in range(len(weights)):
            x = -3.0
            for i in range(9):
                x += F[q, i, e] * F[q, i, e]
            volume += weights[q, e]
            total += weights[q, e] * (c10 * x + c20 * x * x - 2.0 * c10 * relaxed_log(J[q, e]))
        total += 0.5 * volume * lam * relaxed_log(mean[e]) ** 2
    return total


@compiled
def _shear(F, coefficients, shear):  # type: ignore[no-untyped-def]
    """Write 2 psi_1 (e,)."""
    contract(F, F, shear)
    for e in range(len(shear)):
        shear[e] = 2.0 * coefficients[0, e] + 4.0 * coefficients[1, e] * (shear[e] - 3.0)


@compiled
def _add_forces(F, G, slopes, gradients, weights, coefficients, P, scalars, forces):  # type: ignore[no-untyped-def]
    shear = scalars[0]
    forces[:] = 0.0
    for q in range(len(weights)):
        _shear(F[q], coefficients, shear)
        for k in range(9):
            for e in range(len(shear)):
                P[k, e] = weights[q, e] * (shear[e] * F[q, k, e] + slopes[q, e] * G[q, k, e])
        add_divergence(P, gradients[q], forces)


@compiled
def _product(  # type: ignore[no-untyped-def]
    v, F, G, J, slopes, bulk, gradients, weights, coefficients, D, P, scalars, changes, forces
):
    """Write the change of the forces; D, P, scalars, changes are working space."""
    shear, stretch, mean = scalars[0], scalars[1], scalars[2]
    c10, c20 = coefficients[0], coefficients[1]
    mean[:] = 0.0
    for q in range(len(weights)):
        gradient_at(v, gradients[q], D[q])
        contract(G[q], D[q], changes[q])
        for e in range(len(mean)):
            mean[e] += weights[q, e] * changes[q, e]
    forces[:] = 0.0
    for q in range(len(weights)):
        _shear(F[q], coefficients, shear)
        contract(F[q], D[q], stretch)
        cofactor_changes(F[q], D[q], P)
        for e in range(len(mean)):
            changes[q, e] *= -2.0 * c10[e] * relaxed_log_slopes(J[q, e])[1]
            changes[q, e] += bulk[e] * mean[e]
            stretch[e] *= 8.0 * c20[e]
        for k in range(9):
            for e in range(len(mean)):
                change = shear[e] * D[q, k, e] + stretch[e] * F[q, k, e]
                change += slopes[q, e] * P[k, e] + changes[q, e] * G[q, k, e]
                P[k, e] = weights[q, e] * change
        add_divergence(P, gradients[q], forces)
