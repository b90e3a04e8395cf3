"""The full finite-element model of a face: energy, forces and tangent at a state and a set of parameters."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import scipy.sparse as sp

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius.mechanics import elements
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.discretisation import Discretisation, IntArray
from risorius_offline.linear_solver import SOLVERS, LinearSolver, default_solver
from risorius_offline.muscles.assembly import active_tensors

# The film on the skin is neo-Hookean without a volumetric part: its barrier keeps J > 0 on every triangle of the skin.
BARRIER_ONLY = np.array([1.0, 0.0, 0.0])


class FullModel:
    """Finite elements of an anatomy. Displacements are (n, 3) in metres, parameters (p,) as in `Anatomy.inputs`.

    mean_dilatation: volume terms on the element's mean J, which keeps hexahedra, wedges and quadratic tetrahedra from
    locking. solver: a name in `linear_solver.SOLVERS`.
    """

    def __init__(self, anatomy: Anatomy, *, mean_dilatation: bool = True, solver: str | None = None) -> None:
        self.anatomy = anatomy
        self.discretisation = Discretisation(anatomy.points, anatomy.cells, anatomy.skin, anatomy.epidermis)
        self._mean_dilatation = mean_dilatation
        self._solver_name = solver or default_solver()
        by_layer = np.array([material.coefficients for material in anatomy.materials])
        coefficients = [by_layer[block.cells.layer] for block in self.discretisation.volumes]
        coefficients += [by_layer[block.cells.layer] * BARRIER_ONLY for block in self.discretisation.films]
        self._fibres = active_tensors(self.discretisation, anatomy.muscles)
        self._active = [np.zeros((*block.weights.shape, 6)) for block in self.discretisation.blocks]
        # What every kernel takes after the displacement, block by block; `set_parameters` fills the active tensors.
        self._integrands = [
            (block.cells.connectivity, block.gradients, block.weights, *fields)
            for block, *fields in zip(self.discretisation.blocks, coefficients, self._active, strict=True)
        ]
        self._values = np.zeros(self.discretisation.pattern.nnz)
        prescribed = anatomy.skull | anatomy.jaw
        self.free = np.flatnonzero(np.repeat(~prescribed, 3))
        self.prescribed = np.flatnonzero(np.repeat(prescribed, 3))

    @property
    def muscle_count(self) -> int:
        """Number of leading parameters that are muscle activations."""
        return len(self.anatomy.muscles)

    def set_parameters(self, parameters: FloatArray) -> None:
        """Make muscle activations (the leading parameters) act in all later calls."""
        stress = self._fibres @ parameters[: self.muscle_count]
        start = 0
        for active in self._active[: len(self.discretisation.volumes)]:
            active[:] = stress[start : start + active.size].reshape(active.shape)
            start += active.size

    def prescribed_motion(self, parameters: FloatArray) -> FloatArray:
        """Displacement (n, 3) of all bone nodes, zero elsewhere, for the jaw weights in the parameters."""
        u = np.zeros_like(self.anatomy.points)
        motion = self.anatomy.jaw_motion
        if motion is not None:
            lifts = motion.lift_coordinates(parameters[-3:])
            jaw = self.anatomy.jaw
            u[jaw] = np.tensordot(lifts, motion.unit_motions(self.anatomy.points[jaw]), axes=1)
        return u

    def energy(self, u: FloatArray) -> tuple[float, float]:
        """Energy (J) and smallest J of a displacement; the energy is infinite where J <= 0."""
        return self._integrate(u, None)

    def forces(self, u: FloatArray) -> tuple[float, float, FloatArray]:
        """Energy, smallest J and internal plus active nodal forces (n, 3) in newtons."""
        forces = np.zeros_like(u)
        energy, smallest = self._integrate(u, forces)
        return energy, smallest, forces

    def tangent(self, u: FloatArray, *, project: bool = False) -> FloatArray:
        """Values of the tangent in `discretisation.pattern` (a buffer that the next call overwrites)."""
        self._values[:] = 0.0
        for integrand, scatter in zip(self._integrands, self.discretisation.scatter, strict=True):
            elements.tangent(u, *integrand, self._mean_dilatation, project, scatter, self._values)
        return self._values

    def factorise(self, values: FloatArray) -> None:
        """Factorise the free part of a tangent; raises NotPositiveDefiniteError."""
        self.linear_solver.factorise(values[self._free_positions])

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Solution over the free components, (f,) or (f, k), with the last factors."""
        return self.linear_solver.solve(right_hand_side)

    @cached_property
    def linear_solver(self) -> LinearSolver:
        """The sparse solver, analysed once for the free pattern."""
        if self._solver_name not in SOLVERS:
            raise InputError(f"linear solver {self._solver_name!r} is not known; choose one of {', '.join(SOLVERS)}")
        return SOLVERS[self._solver_name](self._free_pattern)

    @cached_property
    def muscle_forces(self) -> FloatArray:
        """(3 n, muscles) nodal forces at rest of each muscle at full activation, newtons."""
        columns = np.zeros((self.discretisation.dof_count, self.muscle_count))
        start = 0
        for block in self.discretisation.volumes:
            size = block.weights.size * 6
            fibres = self._fibres[start : start + size].toarray().reshape(*block.weights.shape, 6, -1)
            full = fibres[:, :, [[0, 3, 5], [3, 1, 4], [5, 4, 2]], :]
            nodal = np.einsum("eq,eqijm,eqaj->eaim", block.weights, full, block.gradients, optimize=True)
            dofs = 3 * block.cells.connectivity[:, :, None] + np.arange(3)
            np.add.at(columns, dofs, nodal)
            start += size
        return columns

    @cached_property
    def lift_fields(self) -> FloatArray:
        """(4, n, 3) unit jaw motions, extended into the tissue by linear elasticity at rest; empty without a jaw."""
        motion = self.anatomy.jaw_motion
        if motion is None:
            return np.zeros((0, *self.anatomy.points.shape))
        self.set_parameters(np.zeros(len(self.anatomy.inputs.parameters)))
        values = self.tangent(np.zeros_like(self.anatomy.points))
        self.factorise(values)
        pattern = self.discretisation.pattern
        upper = sp.csr_matrix((values.copy(), pattern.indices, pattern.indptr), shape=pattern.shape)
        stiffness = upper + sp.triu(upper, 1).T
        fields = np.where(self.anatomy.jaw[:, None], motion.unit_motions(self.anatomy.points), 0.0)
        flat = fields.reshape(len(fields), -1)
        flat[:, self.free] = -self.solve((stiffness @ flat.T)[self.free]).T
        return fields

    def point_jacobians(self, u: FloatArray) -> FloatArray:
        """J at every quadrature point, then on every triangle of the skin where there is an epidermis."""
        values = []
        for block in self.discretisation.blocks:
            gradient = np.einsum("eai,eqaj->eqij", u[block.cells.connectivity], block.gradients)
            values.append(np.linalg.det(gradient + np.eye(3)).ravel())
        return np.concatenate(values)

    def _integrate(self, u: FloatArray, forces: FloatArray | None) -> tuple[float, float]:
        total, smallest = 0.0, np.inf
        target = np.empty((0, 3)) if forces is None else forces
        for integrand in self._integrands:
            energy, lowest = elements.energy_and_forces(
                u, *integrand, self._mean_dilatation, forces is not None, target
            )
            total, smallest = total + energy, min(smallest, lowest)
        return total, smallest

    @cached_property
    def _free_pattern(self) -> sp.csr_matrix:
        pattern = self.discretisation.pattern
        numbered = sp.csr_matrix((np.arange(1.0, pattern.nnz + 1), pattern.indices, pattern.indptr), pattern.shape)
        free = numbered[self.free][:, self.free]
        free.sort_indices()
        return free

    @cached_property
    def _free_positions(self) -> IntArray:
        return self._free_pattern.data.astype(np.int64) - 1
