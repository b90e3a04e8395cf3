"""The physics of a face for reduced coordinates: energy, gradient and products with the stiffness."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from risorius.hyper_reduction.cubature import node_components
from risorius.hyper_reduction.lanes import compiled
from risorius.hyper_reduction.muscles import ReducedMuscles
from risorius.hyper_reduction.terms import Floats, Term
from risorius.jaw import FloatArray


class ReducedBody:
    """Energy of reduced coordinates q = (lifts, modal part): passive terms on sampled nodes, muscles exactly.

    terms: with connectivity into the sampled nodes. fields: (r, k, 3) displacement of these per unit coordinate; the
    first `lifts` are prescribed. Not thread-safe: it holds the state of the last `deform`.
    """

    def __init__(self, terms: Sequence[Term], fields: Floats, lifts: int, muscles: ReducedMuscles) -> None:
        dtype = fields.dtype
        rank = len(fields)
        self.lifts, self.rank = lifts, rank - lifts
        self.terms = tuple(terms)
        self._fields = np.ascontiguousarray(fields.reshape(rank, -1).T)
        self._modes = np.ascontiguousarray(self._fields[:, lifts:])
        self._dofs = [node_components(term.connectivity).astype(np.int32) for term in self.terms]
        self._gathered = [np.empty(dofs.shape, dtype) for dofs in self._dofs]
        self._muscles = ReducedMuscles(muscles.stiffness.astype(dtype), muscles.pull.astype(dtype))
        self._active, self._pull = np.zeros((rank, rank), dtype), np.zeros(rank, dtype)
        self._forces = np.empty(len(self._fields), dtype)
        self.q = np.zeros(rank, dtype)
        self.u = np.zeros(len(self._fields), dtype)
        self._set_terms()

    def set_activations(self, activations: FloatArray) -> None:
        """Make muscle activations (m,) act in all later calls."""
        self._muscles.combined(activations, self._active, self._pull)

    def deform(self, q: Floats) -> None:
        """Take coordinates (r,)."""
        self.q[:] = q
        _times(self._fields, self.q, self.u)
        self._set_terms()

    def image(self, direction: Floats, out: Floats) -> None:
        """Write the displacement (3 k,) of the sampled nodes for a modal direction."""
        _times(self._modes, direction, out)

    def move(self, step: float, direction: Floats, image: Floats) -> None:
        """Move by a step along a modal direction with its image."""
        self.q[self.lifts :] += self.q.dtype.type(step) * direction
        self.u += self.u.dtype.type(step) * image
        self._set_terms()

    def energy(self) -> float:
        """Joules, less a constant; finite for all coordinates."""
        passive = sum(term.energy() for term in self.terms)
        return passive + float(self.q @ (0.5 * (self._active @ self.q) + self._pull))

    def gradient(self, out: Floats) -> None:
        """Write the derivative (r,) of the energy by the modal part, joules."""
        self._forces[:] = 0.0
        for term, dofs in zip(self.terms, self._dofs, strict=True):
            _scatter(term.forces(), dofs, self._forces)
        np.dot(self._active[self.lifts :], self.q, out=out)
        out += self._pull[self.lifts :]
        _add_transposed_times(self._modes, self._forces, out)

    def product(self, direction: Floats, image: Floats, out: Floats) -> None:
        """Write the change (r,) of the gradient along a modal direction with its image."""
        self._forces[:] = 0.0
        for term, dofs, gathered in zip(self.terms, self._dofs, self._gathered, strict=True):
            _gather(image, dofs, gathered)
            _scatter(term.product(gathered), dofs, self._forces)
        np.dot(self._active[self.lifts :, self.lifts :], direction, out=out)
        _add_transposed_times(self._modes, self._forces, out)

    def stiffness(self) -> FloatArray:
        """Second derivatives (r, r) of the energy by the modal part."""
        columns = np.empty((self.rank, self.rank), self.q.dtype)
        image = np.empty_like(self.u)
        for column, direction in zip(columns, np.eye(self.rank, dtype=self.q.dtype), strict=True):
            self.image(direction, image)
            self.product(direction, image, column)
        return 0.5 * (columns + columns.T).astype(np.float64)

    def smallest_jacobian(self) -> float:
        """Smallest J on the cubature."""
        return min(term.smallest_jacobian() for term in self.terms)

    def _set_terms(self) -> None:
        for term, dofs, gathered in zip(self.terms, self._dofs, self._gathered, strict=True):
            _gather(self.u, dofs, gathered)
            term.deform(gathered)


@compiled
def _gather(u, dofs, out):  # type: ignore[no-untyped-def]
    for a in range(dofs.shape[0]):
        for e in range(dofs.shape[1]):
            out[a, e] = u[dofs[a, e]]


@compiled
def _scatter(forces, dofs, out):  # type: ignore[no-untyped-def]
    for a in range(dofs.shape[0]):
        for e in range(dofs.shape[1]):
            out[dofs[a, e]] += forces[a, e]


@compiled
def _times(matrix, vector, out):  # type: ignore[no-untyped-def]
    for row in range(matrix.shape[0]):
        total = matrix[row, 0] * vector[0]
        for column in range(1, matrix.shape[1]):
            total += matrix[row, column] * vector[column]
        out[row] = total


@compiled
def _add_transposed_times(matrix, vector, out):  # type: ignore[no-untyped-def]
    for row in range(matrix.shape[0]):
        value = vector[row]
        for column in range(matrix.shape[1]):
            out[column] += matrix[row, column] * value
