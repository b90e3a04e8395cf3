"""One implicit stage of a time step as a minimisation.

At the end of a stage velocity and acceleration are differences from anchors that are known before it,

    v = rate (u - u_anchor),    a = rate (v - v_anchor),

so that M a + C v + dE/du = 0 is where, with w = u - u_anchor, this is stationary:

    E(u) + 1/2 w . (rate^2 M + rate C) w - rate w . M v_anchor + 1/2 v_anchor . M v_anchor
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.full_model import FullModel
from risorius_offline.inertia import Inertia

# A body strained less than this is as good as at rest: its forces are no measure of what a residual should be.
STRAIN_OF_REST = 1e-6


@dataclass(frozen=True)
class Motion:
    """Displacement u (n, 3) in metres and velocity (n, 3) in m/s."""

    u: FloatArray
    velocity: FloatArray


@dataclass(frozen=True)
class UnitStrain:
    """Energy (J) and norm of nodal forces (N), both of the order of unit strain: rounding is relative to them."""

    energy: float
    force: float

    @classmethod
    def of(cls, model: FullModel) -> UnitStrain:
        """The logarithm of J rounds by c10 in the energy, the dilatation by the bulk modulus in the forces."""
        c10 = np.array([material.c10 for material in model.anatomy.materials])
        bulk = np.array([material.bulk for material in model.anatomy.materials])
        layer = np.concatenate([block.cells.layer for block in model.discretisation.volumes])
        volume = np.concatenate([block.weights.sum(axis=1) for block in model.discretisation.volumes])
        return cls(float(c10[layer] @ volume), float(np.linalg.norm(bulk[layer] * volume ** (2 / 3))))


class StageEnergy:
    """What a stage minimises, a `newton.Energy`.

    It is counted from a datum, minus the energy of unit strain, which sets the size of its rounding: otherwise, where
    its terms cancel, a line search takes rounding for an ascent.
    """

    def __init__(
        self, model: FullModel, inertia: Inertia, stiffness: FloatArray, unit: UnitStrain, anchor: Motion, rate: float
    ) -> None:
        self.free = model.free
        self._model = model
        self._anchor, self._rate = anchor, rate
        self._values, self._metric = inertia.metric(rate, stiffness)
        self._momentum = rate * (inertia.mass @ anchor.velocity.ravel())
        self._datum = unit.energy + inertia.kinetic_energy(anchor.velocity)
        self._force_of_rest = STRAIN_OF_REST * unit.force
        self._resistance = np.zeros(model.discretisation.dof_count)

    def motion(self, u: FloatArray) -> Motion:
        """The end of the stage at displacement u."""
        return Motion(u, self._rate * (u - self._anchor.u))

    def energy(self, u: FloatArray) -> float:
        """Joules above the datum; infinite where u is not admissible."""
        w = (u - self._anchor.u).ravel()
        return self._datum + self._model.energy(u) + float(w @ (0.5 * (self._metric @ w) - self._momentum))

    def forces(self, u: FloatArray) -> tuple[float, float, FloatArray]:
        """Energy, smallest J and dE/du + M a + C v (n, 3) in newtons; at prescribed nodes these are reactions."""
        energy, smallest, forces = self._model.forces(u)
        w = (u - self._anchor.u).ravel()
        pull = self._metric @ w
        self._resistance = pull - self._momentum
        energy += self._datum + float(w @ (0.5 * pull - self._momentum))
        return energy, smallest, forces + self._resistance.reshape(u.shape)

    def factorise(self, u: FloatArray, *, project: bool = False) -> None:
        """Factorise the second derivatives over the free components; raises NotPositiveDefiniteError."""
        values, blocks = self._model.tangent(u, project=project)
        self._model.system.factorise(values + self._values, blocks)

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Solution over the free components with the last factors."""
        return self._model.solve(right_hand_side)

    def largest_step(self, u: FloatArray, direction: FloatArray) -> float:
        """Fraction in (0, 1] of a direction (n, 3) that every effect admits all along."""
        return self._model.largest_step(u, direction)

    def force_scale(self, forces: FloatArray) -> float:
        """Norm (N) of muscle forces, reactions, and inertia with damping where `forces` was last asked."""
        resistance = float(np.linalg.norm(self._resistance[self.free]))
        return math.hypot(self._model.force_scale(forces), resistance, self._force_of_rest)
