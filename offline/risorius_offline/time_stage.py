"""One implicit stage of a time step as a minimisation.

At the end of a stage velocity and acceleration are differences from anchors that are known before it,

    v = rate (u - u_anchor),    a = rate (v - v_anchor),

so that M a + C v + dE/du = 0 is where, with w = u - u_anchor, this is stationary:

    E(u) + 1/2 w . (rate^2 M + rate C) w - rate w . M v_anchor
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.effects import NodeBlocks
from risorius_offline.full_model import FullModel
from risorius_offline.inertia import Inertia
from risorius_offline.tangents import Tangents


@dataclass(frozen=True)
class Motion:
    """Displacement u (n, 3) in metres and velocity (n, 3) in m/s."""

    u: FloatArray
    velocity: FloatArray


class StageEnergy:
    """What a stage minimises, a `newton.Energy`."""

    def __init__(self, model: FullModel, inertia: Inertia, stiffness: FloatArray, anchor: Motion, rate: float) -> None:
        self.free = model.free
        self._model = model
        self._anchor, self._rate = anchor, rate
        self._values, self._metric = inertia.metric(rate, stiffness)
        self._momentum = rate * (inertia.mass @ anchor.velocity.ravel())
        self.energy_scale = model.energy_scale + inertia.kinetic_energy(anchor.velocity)
        self._resistance = np.zeros(model.discretisation.dof_count)

    def motion(self, u: FloatArray) -> Motion:
        """The end of the stage at displacement u."""
        return Motion(u, self._rate * (u - self._anchor.u))

    def energy(self, u: FloatArray) -> float:
        """Joules; infinite where u is not admissible."""
        w = (u - self._anchor.u).ravel()
        return self._model.energy(u) + float(w @ (0.5 * (self._metric @ w) - self._momentum))

    def forces(self, u: FloatArray) -> tuple[float, float, FloatArray]:
        """Energy, smallest J and dE/du + M a + C v (n, 3) in newtons; at prescribed nodes these are reactions."""
        energy, smallest, forces = self._model.forces(u)
        w = (u - self._anchor.u).ravel()
        pull = self._metric @ w
        self._resistance = pull - self._momentum
        energy += float(w @ (0.5 * pull - self._momentum))
        return energy, smallest, forces + self._resistance.reshape(u.shape)

    def tangents(self, u: FloatArray) -> Tangents:
        """Second derivatives of the model's energy at u, without the quadratic terms."""
        return self._model.tangents(u)

    def factorise(self, values: FloatArray, blocks: Sequence[NodeBlocks], *, rough: bool = False) -> None:
        """Factorise second derivatives with those of the quadratic terms; raises NotPositiveDefiniteError."""
        self._model.factorise(values + self._values, blocks, rough=rough)

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Solution over the free components with the last factors."""
        return self._model.solve(right_hand_side)

    def largest_step(self, u: FloatArray, direction: FloatArray) -> float:
        """Fraction in (0, 1] of a direction (n, 3) that every effect admits all along."""
        return self._model.largest_step(u, direction)

    def force_scale(self, forces: FloatArray) -> float:
        """Norm (N) of muscle forces, reactions, and inertia with damping where `forces` was last asked."""
        resistance = float(np.linalg.norm(self._resistance[self.free]))
        return math.hypot(self._model.force_scale(forces), resistance)
