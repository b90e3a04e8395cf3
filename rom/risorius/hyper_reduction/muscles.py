"""Muscles in reduced coordinates, exactly.

Active stress T F a0 (x) a0 in proportion to stretch has the energy T/2 |F a0|^2, (7.2), which is quadratic in the
displacement; a force density (7.3) is linear in it. So every muscle is one matrix and one vector of the coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from risorius.hyper_reduction.terms import Floats
from risorius.jaw import FloatArray
from risorius.mechanics.body import Body

_XX, _YY, _ZZ, _XY, _YZ, _ZX = range(6)
_SYMMETRIC = np.array([[_XX, _XY, _ZX], [_XY, _YY, _YZ], [_ZX, _YZ, _ZZ]])


@dataclass(frozen=True)
class ReducedMuscles:
    """Energy a_m (q' stiffness_m q / 2 + pull_m' q) of muscles at activations a, for coordinates q (r,).

    stiffness (m, r, r) and pull (m, r), joules per unit coordinates.
    """

    stiffness: Floats
    pull: Floats

    @classmethod
    def of(cls, body: Body, points: FloatArray, fields: FloatArray) -> ReducedMuscles:
        """Reduce the muscles of a body with nodes `points` (n, 3) to the fields (r, n, 3) of the coordinates."""
        count, rank = body.active.shape[1], len(fields)
        stiffness = np.empty((count, rank, rank))
        pull = -(body.dead_loads.T @ fields.reshape(rank, -1).T)
        for muscle in range(count):
            scalar = _scalar_stiffness(body, muscle, len(points))
            # The same matrix for every component, of positions: F is the gradient of these.
            pulled = np.stack([scalar @ fields[:, :, i].T for i in range(3)])
            stiffness[muscle] = np.einsum("rni,ins->rs", fields, pulled, optimize=True)
            pull[muscle] += np.einsum("inr,ni->r", pulled, points)
        return cls(stiffness, pull)

    def within(self, muscles: npt.NDArray[np.int64], coordinates: npt.NDArray[np.int64]) -> ReducedMuscles:
        """Return some of the muscles, where only some of the coordinates are not 0."""
        stiffness = self.stiffness[np.ix_(muscles, coordinates, coordinates)]
        return ReducedMuscles(stiffness, self.pull[np.ix_(muscles, coordinates)])

    def combined(self, activations: FloatArray, stiffness: Floats, pull: Floats) -> None:
        """Write the matrix (r, r) and the vector (r,) of all muscles at activations (m,)."""
        _combine(activations, self.stiffness, self.pull, stiffness, pull)


def _scalar_stiffness(body: Body, muscle: int, nodes: int) -> sp.csr_matrix:
    """Matrix (n, n) of one muscle at full activation that turns a component of positions into forces."""
    tensors = body.active[:, [muscle]].toarray().reshape(-1, 6)
    rows, columns, values, start = [], [], [], 0
    for elements in body.passive:
        if start == len(tensors):
            break
        count, points, corners, _ = elements.gradients.shape
        active = tensors[start : start + count * points].reshape(count, points, 6)
        start += count * points
        chosen = np.flatnonzero(active.any(axis=(1, 2)))
        gradients, weights = elements.gradients[chosen], elements.weights[chosen]
        stress = active[chosen][:, :, _SYMMETRIC] * weights[:, :, None, None]
        values.append(np.einsum("eqai,eqij,eqbj->eab", gradients, stress, gradients, optimize=True).ravel())
        numbers = elements.connectivity[chosen]
        rows.append(np.repeat(numbers, corners, axis=1).ravel())
        columns.append(np.tile(numbers, corners).ravel())
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return sp.csr_matrix(entries, shape=(nodes, nodes))


@numba.njit(cache=True, fastmath={"contract", "nsz", "arcp", "reassoc"})
def _combine(activations, stiffnesses, pulls, stiffness, pull):  # type: ignore[no-untyped-def]
    stiffness[:] = 0.0
    pull[:] = 0.0
    for m in range(len(activations)):
        a = activations[m]
        if a == 0.0:
            continue
        for r in range(len(pull)):
            pull[r] += a * pulls[m, r]
            for s in range(len(pull)):
                stiffness[r, s] += a * stiffnesses[m, r, s]
