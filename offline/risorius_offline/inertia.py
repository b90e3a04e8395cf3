"""Mass and damping of a full model: the matrices M and C of (7.1).

M is the consistent mass matrix, the integral of density N_a N_b. C = alpha M + beta K (Rayleigh), K a tangent of the
tissue.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius.mechanics.material import MASS_DAMPING, STIFFNESS_DAMPING, TISSUE_DENSITY
from risorius_offline.discretisation import Discretisation


@dataclass(frozen=True)
class Medium:
    """What tissue resists motion with; the defaults are those of the published face (Flynn et al. 2015).

    density in kg/m3, mass_damping (alpha) in 1/s, stiffness_damping (beta) in s.
    """

    density: float = TISSUE_DENSITY
    mass_damping: float = MASS_DAMPING
    stiffness_damping: float = STIFFNESS_DAMPING

    def __post_init__(self) -> None:
        if not (self.density > 0 and self.mass_damping >= 0 and self.stiffness_damping >= 0):
            raise InputError(
                f"medium: density = {self.density:g} kg/m3, damping = {self.mass_damping:g} 1/s and "
                f"{self.stiffness_damping:g} s; give a positive density and damping of at least 0"
            )


class Inertia:
    """Mass and damping over all components, free and prescribed."""

    def __init__(self, discretisation: Discretisation, medium: Medium) -> None:
        self._medium, self._pattern = medium, discretisation.pattern
        self._mass_values = mass_values(discretisation, medium.density)
        self.mass = self._symmetric(self._mass_values)

    def metric(self, rate: float, stiffness: FloatArray) -> tuple[FloatArray, sp.csr_matrix]:
        """rate^2 M + rate C in N/m: values in the pattern of the tangent, and the whole symmetric matrix.

        stiffness: values of K, whose part beta is in C.
        """
        values = (rate**2 + rate * self._medium.mass_damping) * self._mass_values
        values += rate * self._medium.stiffness_damping * stiffness
        return values, self._symmetric(values)

    def kinetic_energy(self, velocity: FloatArray) -> float:
        """Joules of a velocity (n, 3) in m/s."""
        return 0.5 * float(velocity.ravel() @ (self.mass @ velocity.ravel()))

    def _symmetric(self, values: FloatArray) -> sp.csr_matrix:
        upper = sp.csr_matrix((values, self._pattern.indices, self._pattern.indptr), shape=self._pattern.shape)
        return (upper + sp.triu(upper, 1).T).tocsr()


def mass_values(discretisation: Discretisation, density: float) -> FloatArray:
    """Values (nnz,) in `discretisation.pattern` of the consistent mass matrix, kilograms, for a density in kg/m3."""
    values = np.zeros(discretisation.pattern.nnz)
    # The films come after the volumes and have no mass of their own.
    for block, scatter in zip(discretisation.volumes, discretisation.scatter, strict=False):
        element = block.cells.element
        points, weights = element.mass_rule
        shapes = element.shape_functions(points)
        corners = discretisation.points[block.cells.connectivity]
        volumes = np.linalg.det(np.einsum("eai,qaj->eqij", corners, element.gradients_at(points))) * weights
        masses = density * np.einsum("eq,qa,qb->eab", volumes, shapes, shapes, optimize=True)
        for axis in range(3):
            positions = scatter[:, axis::3, axis::3]
            upper = positions >= 0
            values += np.bincount(positions[upper], weights=masses[upper], minlength=len(values))
    return values
