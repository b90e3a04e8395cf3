"""The full finite-element model of a face: energy, forces and tangent at a state and a set of parameters."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.discretisation import Discretisation
from risorius_offline.effects import DeadLoad, Effect, NodeBlocks
from risorius_offline.linear_solver import SOLVERS, default_solver
from risorius_offline.muscles.assembly import active_tensors, dead_loads
from risorius_offline.tangent_system import TangentSystem
from risorius_offline.tissue import Tissue


class FullModel:
    """Finite elements of an anatomy. Displacements are (n, 3) in metres, parameters (p,) as in `Anatomy.inputs`.

    effects: further terms of the energy. mean_dilatation: volume terms on the element's mean J, which keeps hexahedra,
    wedges and quadratic tetrahedra from locking. solver: a name in `linear_solver.SOLVERS`.
    """

    def __init__(
        self,
        anatomy: Anatomy,
        effects: Sequence[Effect] = (),
        *,
        mean_dilatation: bool = True,
        solver: str | None = None,
    ) -> None:
        self.anatomy = anatomy
        self.effects = tuple(effects)
        self.discretisation = Discretisation(anatomy.points, anatomy.cells, anatomy.skin, anatomy.epidermis)
        self._solver_name = solver or default_solver()
        self._active_tensors = active_tensors(self.discretisation, anatomy.muscles)
        self._dead_loads = dead_loads(self.discretisation, anatomy.muscles)
        self.tissue = Tissue(self.discretisation, anatomy.materials, self._active_tensors, mean_dilatation)
        prescribed = anatomy.skull | anatomy.jaw
        self.set_parameters(np.zeros(len(anatomy.inputs.parameters)))
        self.free = np.flatnonzero(np.repeat(~prescribed, 3))
        self.prescribed = np.flatnonzero(np.repeat(prescribed, 3))

    @property
    def muscle_count(self) -> int:
        """Number of leading parameters that are muscle activations."""
        return len(self.anatomy.muscles)

    def set_parameters(self, parameters: FloatArray) -> None:
        """Make muscle activations (the leading parameters) and jaw weights act in all later calls."""
        self._activations = parameters[: self.muscle_count]
        self.tissue.set_activations(self._activations)
        self._dead_load = DeadLoad((self._dead_loads @ self._activations).reshape(-1, 3))
        for effect in self.effects:
            effect.set_parameters(parameters)

    def prescribed_motion(self, parameters: FloatArray) -> FloatArray:
        """Displacement (n, 3) of all bone nodes, zero elsewhere, for the jaw weights in the parameters."""
        u = np.zeros_like(self.anatomy.points)
        motion = self.anatomy.jaw_motion
        if motion is not None:
            lifts = motion.lift_coordinates(parameters[-3:])
            jaw = self.anatomy.jaw
            u[jaw] = np.tensordot(lifts, motion.unit_motions(self.anatomy.points[jaw]), axes=1)
        return u

    def follow_bones(self, u: FloatArray, before: FloatArray, after: FloatArray) -> FloatArray:
        """Displacement u (n, 3) with the bones moved from parameters `before` to `after`, where they land exactly.

        Tissue follows to first order, as far as surfaces let it.
        """
        followed = u.copy()
        motion = self.anatomy.jaw_motion
        if motion is not None:
            change = motion.lift_coordinates(after[-3:]) - motion.lift_coordinates(before[-3:])
            direction = np.tensordot(change, self.lift_fields, axes=1)
            followed += self.largest_step(u, direction) * direction
        followed.reshape(-1)[self.prescribed] = self.prescribed_motion(after).reshape(-1)[self.prescribed]
        return followed

    def energy(self, u: FloatArray) -> float:
        """Energy (J) of a displacement; infinite where it is not admissible (J <= 0, or surfaces that cross)."""
        total = self.tissue.energy(u)[0] + self._dead_load.energy(u)
        for effect in self.effects:
            if np.isfinite(total):
                total += effect.energy(u)
        return total

    def forces(self, u: FloatArray) -> tuple[float, float, FloatArray]:
        """Energy, smallest J and nodal forces (n, 3) in newtons: the derivative of the energy."""
        forces = np.zeros_like(u)
        total, smallest = self.tissue.add_forces(u, forces)
        total += self._dead_load.add_forces(u, forces)
        for effect in self.effects:
            total += effect.add_forces(u, forces)
        return total, smallest, forces

    def tangent(self, u: FloatArray, *, project: bool = False) -> tuple[FloatArray, list[NodeBlocks]]:
        """Second derivatives of the energy: values in `discretisation.pattern` (overwritten by the next call), blocks.

        With `project` both are made of positive semi-definite pieces.
        """
        return self.tissue.tangent(u, project=project), [
            effect.second_derivatives(u, project=project) for effect in self.effects
        ]

    def factorise(self, u: FloatArray, *, project: bool = False) -> None:
        """Factorise the free part of the tangent at u; raises NotPositiveDefiniteError."""
        self.system.factorise(*self.tangent(u, project=project))

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Solution over the free components, (f,) or (f, k), with the last factors."""
        return self.system.solve(right_hand_side)

    def largest_step(self, u: FloatArray, direction: FloatArray) -> float:
        """Fraction in (0, 1] of a direction (n, 3) that every effect admits all along."""
        return min((effect.largest_step(u, direction) for effect in self.effects), default=1.0)

    def force_scale(self, forces: FloatArray) -> float:
        """Norm (N) of muscle forces at rest and of the reactions in forces (n, 3): what a residual is compared with."""
        active = self.muscle_forces @ self._activations
        return float(np.hypot(np.linalg.norm(active), np.linalg.norm(forces.reshape(-1)[self.prescribed])))

    @cached_property
    def system(self) -> TangentSystem:
        """The sparse system, analysed once for the free pattern."""
        if self._solver_name not in SOLVERS:
            raise InputError(f"linear solver {self._solver_name!r} is not known; choose one of {', '.join(SOLVERS)}")
        return TangentSystem(self.discretisation.pattern, self.free, SOLVERS[self._solver_name])

    @cached_property
    def muscle_forces(self) -> FloatArray:
        """(3 n, muscles) nodal forces at rest of each muscle at full activation, newtons."""
        columns = -self._dead_loads
        start = 0
        for block in self.discretisation.volumes:
            size = block.weights.size * 6
            fibres = self._active_tensors[start : start + size].toarray().reshape(*block.weights.shape, 6, -1)
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
        values = self.passive_stiffness(np.zeros_like(self.anatomy.points))
        self.system.factorise(values, [])
        pattern = self.discretisation.pattern
        upper = sp.csr_matrix((values, pattern.indices, pattern.indptr), shape=pattern.shape)
        stiffness = upper + sp.triu(upper, 1).T
        fields = np.where(self.anatomy.jaw[:, None], motion.unit_motions(self.anatomy.points), 0.0)
        flat = fields.reshape(len(fields), -1)
        flat[:, self.free] = -self.solve((stiffness @ flat.T)[self.free]).T
        return fields

    def passive_stiffness(self, u: FloatArray, *, project: bool = False) -> FloatArray:
        """Values (nnz,) in `discretisation.pattern` of the tangent of the tissue at u without activation."""
        self.tissue.set_activations(np.zeros(self.muscle_count))
        values = self.tissue.tangent(u, project=project).copy()
        self.tissue.set_activations(self._activations)
        return values

    def point_jacobians(self, u: FloatArray) -> FloatArray:
        """J at every quadrature point, then on every triangle of the skin where there is an epidermis."""
        values = []
        for block in self.discretisation.blocks:
            gradient = np.einsum("eai,eqaj->eqij", u[block.cells.connectivity], block.gradients)
            values.append(np.linalg.det(gradient + np.eye(3)).ravel())
        return np.concatenate(values)
