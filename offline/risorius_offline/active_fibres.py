"""Active fibres of the muscles over all volume blocks, by either law of fibres: the kernels of `mechanics.fibres`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from risorius.jaw import FloatArray
from risorius.mechanics import fibres
from risorius.mechanics.fibres import FibrePoints
from risorius_offline.discretisation import Discretisation


class ActiveFibres:
    """Fibre points of every volume block; law as in `mechanics.fibres`. Activations are (m,), displacements (n, 3)."""

    def __init__(self, discretisation: Discretisation, points: list[FibrePoints], muscle_count: int, law: int) -> None:
        self._discretisation = discretisation
        self.points = points
        self._count = muscle_count
        self.law = law

    def energy(self, u: FloatArray, activations: FloatArray) -> float:
        """Energy in joules; J > 0 everywhere is taken for granted."""
        return self._energy(u, activations, None)

    def add_forces(self, u: FloatArray, activations: FloatArray, forces: FloatArray) -> float:
        """Add dE/du in newtons to `forces` (n, 3) and return the energy."""
        return self._energy(u, activations, forces)

    def add_tangent(self, u: FloatArray, activations: FloatArray, project: bool, values: FloatArray) -> None:
        """Add second derivatives to values in `discretisation.pattern`; with `project` positive semi-definite ones."""
        for (arrays, points), scatter in zip(self._blocks(), self._discretisation.scatter, strict=False):
            fibres.tangent(u, *arrays, points, activations, self.law, project, scatter, values)

    def muscle_forces(self, u: FloatArray) -> FloatArray:
        """(3 n, m) nodal forces dE/du in newtons of each muscle at full activation."""
        columns = np.zeros((*u.shape, self._count))
        for arrays, points in self._blocks():
            fibres.add_muscle_forces(u, *arrays, points, self.law, columns)
        return columns.reshape(u.size, self._count)

    def integrals(self, u: FloatArray, activations: FloatArray) -> FloatArray:
        """(m, 4) volume (m3), volume times stretch, integral of fibre stress (N m), released energy (J), by muscle."""
        sums = np.zeros((self._count, 4))
        for arrays, points in self._blocks():
            fibres.add_integrals(u, *arrays, points, activations, self.law, sums)
        return sums

    def _energy(self, u: FloatArray, activations: FloatArray, forces: FloatArray | None) -> float:
        target = np.empty((0, 3)) if forces is None else forces
        return sum(
            fibres.energy_and_forces(u, *arrays, points, activations, self.law, forces is not None, target)
            for arrays, points in self._blocks()
        )

    def _blocks(self) -> Iterator[tuple[tuple[Any, ...], FibrePoints]]:
        for block, points in zip(self._discretisation.volumes, self.points, strict=True):
            yield (block.cells.connectivity, block.gradients, block.weights), points
