"""Tissue of an anatomy: the element kernels over all blocks, with the active stress of the muscles."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import scipy.sparse as sp

from risorius.jaw import FloatArray
from risorius.mechanics import elements
from risorius.mechanics.material import Yeoh
from risorius_offline.discretisation import Discretisation

# The film on the skin is neo-Hookean without a volumetric part: its barrier keeps J > 0 on every triangle of the skin.
BARRIER_ONLY = np.array([1.0, 0.0, 0.0])


class Tissue:
    """Elastic energy and active stress of a discretisation; materials by layer number.

    active_tensors: sparse (6 points, muscles), tensor (xx, yy, zz, xy, yz, zx) of every muscle at full activation.
    """

    def __init__(
        self,
        discretisation: Discretisation,
        materials: tuple[Yeoh, ...],
        active_tensors: sp.csr_matrix,
        mean_dilatation: bool,
    ) -> None:
        self.discretisation = discretisation
        self.active_tensors = active_tensors
        self.mean_dilatation = mean_dilatation
        by_layer = np.array([material.coefficients for material in materials])
        self.coefficients = [by_layer[block.cells.layer] for block in discretisation.volumes]
        self.coefficients += [by_layer[block.cells.layer] * BARRIER_ONLY for block in discretisation.films]
        self._active = [np.zeros((*block.weights.shape, 6)) for block in discretisation.blocks]
        # What every kernel takes after the displacement, block by block; `set_activations` fills the active tensors.
        self._integrands = [
            (block.cells.connectivity, block.gradients, block.weights, *fields)
            for block, *fields in zip(discretisation.blocks, self.coefficients, self._active, strict=True)
        ]

    def set_activations(self, activations: FloatArray) -> None:
        """Make muscle activations (m,) act in all later calls."""
        stress = self.active_tensors @ activations
        start = 0
        for active in self._active[: len(self.discretisation.volumes)]:
            active[:] = stress[start : start + active.size].reshape(active.shape)
            start += active.size

    def energy(self, u: FloatArray) -> tuple[float, float]:
        """Energy (J) and smallest J of a displacement (n, 3); the energy is infinite where J <= 0."""
        return self._integrate(u, None)

    def add_forces(self, u: FloatArray, forces: FloatArray) -> tuple[float, float]:
        """Add internal and active nodal forces (N) to `forces` (n, 3); return energy and smallest J."""
        return self._integrate(u, forces)

    def tangent(self, u: FloatArray, *, project: bool = False) -> FloatArray:
        """Values of the tangent in `discretisation.pattern` (a buffer that the next call overwrites)."""
        self._values[:] = 0.0
        for integrand, scatter in zip(self._integrands, self.discretisation.scatter, strict=True):
            elements.tangent(u, *integrand, self.mean_dilatation, project, scatter, self._values)
        return self._values

    @cached_property
    def _values(self) -> FloatArray:
        return np.zeros(self.discretisation.pattern.nnz)

    def _integrate(self, u: FloatArray, forces: FloatArray | None) -> tuple[float, float]:
        total, smallest = 0.0, np.inf
        target = np.empty((0, 3)) if forces is None else forces
        for integrand in self._integrands:
            energy, lowest = elements.energy_and_forces(u, *integrand, self.mean_dilatation, forces is not None, target)
            total, smallest = total + energy, min(smallest, lowest)
        return total, smallest
