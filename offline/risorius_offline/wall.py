"""The walls of a discretisation: what keeps J > 0 everywhere in its cells, not only at their quadrature points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from risorius.jaw import FloatArray
from risorius.mechanics import wall
from risorius.mechanics.material import Yeoh
from risorius_offline.bernstein import BernsteinForm, bernstein_form
from risorius_offline.discretisation import Discretisation, IntArray

# A cell feels the wall where it is squeezed below this part of its volume at rest.
HEIGHT = 0.5
# Energy of a wall, relative to c10 times the volume at rest: with less of it Newton's method takes more iterations.
STRENGTH = 3.0
# Halvings of a cell whose coefficients at rest are not all positive, though its determinant is.
DEEPEST = 3


@dataclass(frozen=True)
class Wall:
    """Cells of one type with one form of their determinants; arrays as in `mechanics.wall`."""

    points: FloatArray
    cells: IntArray
    connectivity: IntArray
    gradients: FloatArray
    form: FloatArray
    heights: FloatArray
    weights: FloatArray
    scatter: npt.NDArray[np.int32]

    def energy(self, u: FloatArray) -> float:
        """Joules at a displacement u (n, 3); infinite where J > 0 does not hold for certain."""
        return float(wall.energy_and_forces(self.points + u, *self._arrays, False, np.empty((0, 3))))

    def add_forces(self, u: FloatArray, forces: FloatArray) -> float:
        """Add nodal forces (N) to `forces` (n, 3) and return the energy."""
        return float(wall.energy_and_forces(self.points + u, *self._arrays, True, forces))

    def add_tangent(self, u: FloatArray, project: bool, values: FloatArray) -> None:
        """Add second derivatives to values in `discretisation.pattern`; with `project` positive semi-definite ones."""
        wall.tangent(self.points + u, *self._arrays, project, self.scatter, values)

    @property
    def _arrays(self) -> tuple[npt.NDArray[np.generic], ...]:
        return self.cells, self.connectivity, self.gradients, self.form, self.heights, self.weights


def walls(discretisation: Discretisation, materials: tuple[Yeoh, ...]) -> tuple[Wall, ...]:
    """Walls of all cells but those in which J is constant, and those that are inverted somewhere at rest."""
    c10 = np.array([material.c10 for material in materials])
    found = []
    for block, scatter in zip(discretisation.volumes, discretisation.scatter, strict=False):
        element, connectivity = block.cells.element, block.cells.connectivity
        if element.jacobian_is_constant:
            continue
        bernstein = bernstein_form(block.cells.cell_type)
        gradients = np.ascontiguousarray(np.moveaxis(bernstein.gradients, 0, 2))
        energies = STRENGTH * c10[block.cells.layer] * block.weights.sum(axis=1)
        determinants = bernstein.determinants(discretisation.points[connectivity])
        for cells, form, rest in _by_depth(bernstein, determinants):
            weights = energies[cells] / len(form)
            shape = (discretisation.points, cells, connectivity, gradients)
            found.append(Wall(*shape, form, HEIGHT * rest, weights, scatter))
    return tuple(found)


def _by_depth(bernstein: BernsteinForm, determinants: FloatArray) -> Iterator[tuple[IntArray, FloatArray, FloatArray]]:
    """Cells, form and coefficients at rest, at the depth at which these are positive; determinants (e, k) at rest."""
    open_ = np.arange(len(determinants))
    for depth in range(DEEPEST + 1):
        form = bernstein.form_of_parts(depth)
        rest = determinants[open_] @ form.T
        valid = (rest > 0.0).all(axis=1)
        if valid.any():
            yield open_[valid], form, np.ascontiguousarray(rest[valid])
        open_ = open_[~valid]
        if not len(open_):
            return
