"""The full finite-element model of a face: energy, forces and tangent at a state and a set of parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius.mechanics.fibres import PROPORTIONAL
from risorius_offline.active_fibres import ActiveFibres
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.discretisation import Discretisation, IntArray
from risorius_offline.effects import NO_CONTACTS, DeadLoad, Effect, NodeBlocks
from risorius_offline.linear_solver import ROUGH_SOLVERS, SOLVERS, default_solver
from risorius_offline.muscles.assembly import active_tensors, dead_loads, fibre_points
from risorius_offline.tangent_system import TangentSystem
from risorius_offline.tangents import TRUE, Projection, Tangents
from risorius_offline.tissue import Tissue
from risorius_offline.unit_strain import UnitStrain
from risorius_offline.untangling import Untangling
from risorius_offline.wall import walls

# A body strained less than this is as good as at rest.
STRAIN_OF_REST = 1e-6
# Of a displacement that is not admissible: what mends its cells may push it into a bone, and the other way round.
MOST_MENDINGS = 4
# Contact pairs, as `Effect.contacts`, of effects.
Contacts = tuple[tuple[Effect, IntArray], ...]


class FullModel:
    """Finite elements of an anatomy. Displacements are (n, 3) in metres, parameters (p,) as in `Anatomy.inputs`.

    effects: further terms of the energy. fibre_law: of `mechanics.fibres`; HILL is the muscles' force-length relation.
    mean_dilatation: volume terms on the element's mean J, which keeps hexahedra, wedges and quadratic tetrahedra from
    locking. walled: J > 0 everywhere in a cell, at a little energy where it is squeezed below half its volume; without,
    J > 0 holds at quadrature points. solver: a name in `linear_solver.SOLVERS`.
    factorised_for: the equilibrium at which the last factors are those of the tangent, as who finds it says.
    """

    def __init__(
        self,
        anatomy: Anatomy,
        effects: Sequence[Effect] = (),
        *,
        fibre_law: int = PROPORTIONAL,
        mean_dilatation: bool = True,
        walled: bool = True,
        solver: str | None = None,
    ) -> None:
        self.anatomy = anatomy
        self.effects = tuple(effects)
        self.discretisation = Discretisation(anatomy.points, anatomy.cells, anatomy.skin, anatomy.epidermis)
        self._solver_name = solver or default_solver()
        self.factorised_for: object = None
        points = fibre_points(self.discretisation, anatomy.muscles)
        self.fibres = ActiveFibres(self.discretisation, points, self.muscle_count, fibre_law)
        # In proportion to the stretch, active stress is a constant tensor, which the tissue's kernels take on the way.
        self._fibres_in_tissue = fibre_law == PROPORTIONAL
        tensors = active_tensors(self.discretisation, points, self.muscle_count)
        self.tissue = Tissue(self.discretisation, anatomy.materials, tensors * self._fibres_in_tissue, mean_dilatation)
        self.walls = walls(self.discretisation, anatomy.materials) if walled else ()
        self.dead_loads = dead_loads(self.discretisation, anatomy.muscles)
        self._unit_motions = anatomy.unit_motions()
        prescribed = anatomy.prescribed
        self.set_parameters(np.zeros(len(anatomy.inputs.parameters)))
        self.free = np.flatnonzero(np.repeat(~prescribed, 3))
        self.prescribed = np.flatnonzero(np.repeat(prescribed, 3))

    @property
    def muscle_count(self) -> int:
        """Number of leading parameters that are muscle activations."""
        return len(self.anatomy.muscles)

    def set_parameters(self, parameters: FloatArray) -> None:
        """Make muscle activations (the leading parameters) and pose weights act in all later calls."""
        self._activations = parameters[: self.muscle_count]
        self.tissue.set_activations(self._activations)
        self._dead_load = DeadLoad((self.dead_loads @ self._activations).reshape(-1, 3))
        for effect in self.effects:
            effect.set_parameters(parameters)

    def prescribed_motion(self, parameters: FloatArray) -> FloatArray:
        """Displacement (n, 3) of bones and tarsal plates, zero elsewhere, for the pose weights in the parameters."""
        return np.tensordot(self._lift_coordinates(parameters), self._unit_motions, axes=1)

    def follow_bones(self, u: FloatArray, before: FloatArray, after: FloatArray) -> FloatArray:
        """Displacement u (n, 3) with the bones moved from parameters `before` to `after`, where they land exactly.

        Tissue follows to first order, as far as surfaces let it.
        """
        direction = self._following(before, after)
        followed = u + self.largest_step(u, direction) * direction
        followed.reshape(-1)[self.prescribed] = self.prescribed_motion(after).reshape(-1)[self.prescribed]
        return followed

    def followed_share(self, u: FloatArray, before: FloatArray, after: FloatArray) -> float:
        """Share of the way from parameters `before` to `after` on which surfaces let tissue follow the bones."""
        return self.largest_step(u, self._following(before, after))

    def _following(self, before: FloatArray, after: FloatArray) -> FloatArray:
        """First-order displacement (n, 3) of tissue and bones between two sets of parameters."""
        change = self._lift_coordinates(after) - self._lift_coordinates(before)
        return np.tensordot(change, self.lift_fields, axes=1)

    def _lift_coordinates(self, parameters: FloatArray) -> FloatArray:
        return self.anatomy.poses.lift_coordinates(parameters[self.muscle_count :])

    def energy(self, u: FloatArray) -> float:
        """Energy (J) of a displacement; infinite where it is not admissible (J <= 0, or surfaces that cross)."""
        total = self.tissue.energy(u)[0] + self._dead_load.energy(u)
        if not np.isfinite(total):
            return total
        total += sum(wall.energy(u) for wall in self.walls)
        if not self._fibres_in_tissue:
            total += self.fibres.energy(u, self._activations)
        return total + sum(effect.energy(u) for effect in self.effects)

    def forces(self, u: FloatArray) -> tuple[float, float, FloatArray]:
        """Energy, smallest J and nodal forces (n, 3) in newtons: the derivative of the energy, where it is finite."""
        forces = np.zeros_like(u)
        total, smallest = self.tissue.add_forces(u, forces)
        if not np.isfinite(total):
            return total, smallest, forces
        total += self._dead_load.add_forces(u, forces)
        total += sum(wall.add_forces(u, forces) for wall in self.walls)
        if not self._fibres_in_tissue:
            total += self.fibres.add_forces(u, self._activations, forces)
        for effect in self.effects:
            total += effect.add_forces(u, forces)
        return total, smallest, forces

    def tangents(self, u: FloatArray) -> Tangents:
        """Second derivatives of the energy at u in all projections; u and the parameters must not change meanwhile."""
        return Tangents(
            lambda project: self._tangent_of_obstacles(u, project), lambda project: self._tangent_of_tissue(u, project)
        )

    def tangent(self, u: FloatArray, projection: Projection = TRUE) -> tuple[FloatArray, list[NodeBlocks]]:
        """Second derivatives of the energy at u: values in `discretisation.pattern`, and node blocks of the effects."""
        return self.tangents(u).mixed(projection)

    def factorise(self, values: FloatArray, blocks: Sequence[NodeBlocks], *, rough: bool = False) -> None:
        """Factorise the free part of second derivatives, rough: for a direction; raises NotPositiveDefiniteError."""
        self.factorised_for = None
        self.system.factorise(values, blocks, rough=rough)

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Solution over the free components, (f,) or (f, k), with the last factors."""
        return self.system.solve(right_hand_side)

    def admits(self, u: FloatArray) -> bool:
        """Whether a displacement may be started from: its energy is finite, and every effect admits it."""
        return bool(np.isfinite(self.energy(u))) and all(effect.admits(u) for effect in self.effects)

    def admissible(self, u: FloatArray) -> FloatArray | None:
        """A displacement (n, 3) that may be started from: u, or one beside it; None where none is found."""
        if not np.isfinite(u).all():
            return None
        for _ in range(MOST_MENDINGS):
            if self.admits(u):
                return u
            pushed = u.copy()
            for effect in self.effects:
                effect.push_out(pushed)
            u = self._untangling.untangled(pushed, kept=(pushed != u).any(axis=1))
        return u if self.admits(u) else None

    @property
    def contacts(self) -> Contacts:
        """Contact pairs that effects hold."""
        return tuple((effect, effect.contacts) for effect in self.effects)

    def search_contacts(self, u: FloatArray, known: Contacts = ()) -> Contacts:
        """Contact pairs of effects at u, or those that are known of an effect; what effects hold stays."""
        given = {id(effect): pairs for effect, pairs in known}
        return tuple(
            (effect, given[id(effect)] if id(effect) in given else effect.search_contacts(u)) for effect in self.effects
        )

    def hold_contacts(self, contacts: Contacts) -> None:
        """Have effects hold contact pairs, those without any none, in place of those before."""
        given = {id(effect): pairs for effect, pairs in contacts}
        for effect in self.effects:
            effect.hold_contacts(given.get(id(effect), NO_CONTACTS))

    def missed_depth(self, u: FloatArray, contacts: Contacts) -> float:
        """Metres by which something at u is deeper in something by `contacts` than by those that effects hold."""
        return max((effect.missed_depth(u, pairs) for effect, pairs in contacts), default=0.0)

    def largest_step(self, u: FloatArray, direction: FloatArray) -> float:
        """Fraction in (0, 1] of a direction (n, 3) that every effect admits all along."""
        return min((effect.largest_step(u, direction) for effect in self.effects), default=1.0)

    def force_scale(self, forces: FloatArray) -> float:
        """Norm (N) of muscle forces at rest and of the reactions in forces (n, 3): what a residual is compared with.

        At least the forces of a body that is as good as at rest, which are no measure of what a residual should be.
        """
        active = np.linalg.norm(self._muscle_forces_at_rest @ self._activations)
        reactions = np.linalg.norm(forces.reshape(-1)[self.prescribed])
        return math.hypot(active, reactions, STRAIN_OF_REST * self._unit_strain.force)

    @property
    def energy_scale(self) -> float:
        """Energy (J) at unit strain, which rounding is relative to."""
        return self._unit_strain.energy

    @cached_property
    def _untangling(self) -> Untangling:
        return Untangling(self.discretisation, self.anatomy.prescribed)

    @cached_property
    def system(self) -> TangentSystem:
        """The sparse system, analysed once for the free pattern."""
        if self._solver_name not in SOLVERS:
            raise InputError(f"linear solver {self._solver_name!r} is not known; choose one of {', '.join(SOLVERS)}")
        exact, rough = SOLVERS[self._solver_name](), ROUGH_SOLVERS.get(self._solver_name)
        return TangentSystem(self.discretisation.pattern, self.free, exact, rough() if rough else None)

    def muscle_forces(self, u: FloatArray) -> FloatArray:
        """(3 n, muscles) derivatives of the forces at u by the activations, newtons at full activation."""
        return self.fibres.muscle_forces(u) - self.dead_loads

    @cached_property
    def lift_fields(self) -> FloatArray:
        """(lifts, n, 3) unit motions of the poses, extended into the tissue by linear elasticity at rest."""
        fields = self._unit_motions.copy()
        if not len(fields):
            return fields
        values = self.passive_stiffness(np.zeros_like(self.anatomy.points))
        self.factorise(values, [])
        pattern = self.discretisation.pattern
        upper = sp.csr_matrix((values, pattern.indices, pattern.indptr), shape=pattern.shape)
        stiffness = upper + sp.triu(upper, 1).T
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
        blocks = self.discretisation.blocks
        return np.concatenate([np.linalg.det(block.deformation_gradients(u)).ravel() for block in blocks])

    def _tangent_of_obstacles(self, u: FloatArray, project: bool) -> tuple[FloatArray, list[NodeBlocks]]:
        values = np.zeros(self.discretisation.pattern.nnz)
        for wall in self.walls:
            wall.add_tangent(u, project, values)
        return values, [effect.second_derivatives(u, project=project) for effect in self.effects]

    def _tangent_of_tissue(self, u: FloatArray, project: bool) -> FloatArray:
        values = self.tissue.tangent(u, project=project).copy()
        if not self._fibres_in_tissue:
            self.fibres.add_tangent(u, self._activations, project, values)
        return values

    @cached_property
    def _muscle_forces_at_rest(self) -> FloatArray:
        return self.muscle_forces(np.zeros_like(self.anatomy.points))

    @cached_property
    def _unit_strain(self) -> UnitStrain:
        return UnitStrain.of(self.discretisation, self.anatomy.materials)
