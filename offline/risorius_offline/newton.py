"""A guarded Newton method for the minimum of an energy that is infinite where a state is not admissible.

Directions come from a factorised tangent; when it is not positive definite, as much of its projection (Teran et al.
2005) is mixed in as it takes: projection alone is too stiff where tissue is about to buckle. A line search on the
energy (Armijo) never leaves the admissible states: J > 0 at every point, no surface through another. Factors are kept
while they contract the residual well, with what the steps show put into them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray
from risorius_offline.effects.effect import NodeBlocks
from risorius_offline.linear_solver import NotPositiveDefiniteError
from risorius_offline.secants import Secants
from risorius_offline.tangents import PROJECTED, TRUE, Projection, Tangents

ARMIJO = 1e-4
SMALLEST_STEP_LENGTH = 1e-6
GOOD_CONTRACTION = 0.25
# Tried one after the other. Obstacles cost little to project.
PROJECTIONS = (TRUE, Projection(True, 0.0), Projection(True, 0.25), PROJECTED)
ONLY_OBSTACLES = 1
# Changes of the energy below this, relative to its scale, are rounding, and the line search cannot judge them.
ENERGY_PRECISION = 1e-13


class Energy(Protocol):
    """What is minimised over the free components of a displacement u (n, 3)."""

    free: IntArray

    @property
    def energy_scale(self) -> float:
        """Joules that the terms of the energy are made of, though they may cancel: what rounding is relative to."""
        ...

    def energy(self, u: FloatArray) -> float:
        """Joules; infinite where u is not admissible."""
        ...

    def forces(self, u: FloatArray) -> tuple[float, float, FloatArray]:
        """Energy, smallest J and the derivative of the energy (n, 3), newtons, where the energy is finite."""
        ...

    def tangents(self, u: FloatArray) -> Tangents:
        """Second derivatives at u."""
        ...

    def factorise(self, values: FloatArray, blocks: Sequence[NodeBlocks], *, rough: bool = False) -> None:
        """Factorise what `tangents` mix, over the free components, rough: for a direction that descends.

        Raises NotPositiveDefiniteError.
        """
        ...

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Solution over the free components with the last factors."""
        ...

    def largest_step(self, u: FloatArray, direction: FloatArray) -> float:
        """Fraction in (0, 1] of a direction (n, 3) that stays admissible all along."""
        ...

    def force_scale(self, forces: FloatArray) -> float:
        """Norm (N) of the forces that balance in forces (n, 3), not zero: what a residual is compared with."""
        ...


@dataclass
class SolverReport:
    """What a solve took and reached: iteration counts, smallest J, energy (J), relative residual, load steps.

    converged: forces balance. stable: the second derivatives are positive definite there, so the balance is a minimum;
    told only where equilibria are looked for.
    """

    converged: bool = False
    stable: bool = False
    iterations: int = 0
    factorisations: int = 0
    projections: int = 0
    steps: int = 0
    rejected_steps: int = 0
    smallest_jacobian: float = 1.0
    energy: float = 0.0
    residual: float = 0.0


@dataclass(frozen=True)
class GuardedNewton:
    """tolerance: norm of the free forces relative to the forces that balance. max_iterations: before giving up.

    rough: whether factors are of less precision, for less time, which fail where cells are near collapse. watch: is
    handed every displacement (n, 3) at which a tangent is made.
    """

    tolerance: float
    max_iterations: int
    rough: bool = False
    watch: Callable[[FloatArray], None] | None = None

    def minimise(
        self, energy: Energy, u: FloatArray, report: SolverReport, level: int | None = None
    ) -> FloatArray | None:
        """Minimum reached from an admissible u (n, 3), prescribed components kept; None when none is in reach.

        level: of `PROJECTIONS` in the factors at hand, for the first step; None where they are of another problem.
        The report is added to: counts go on, energy, residual and smallest J are those of the last iterate.
        """
        last_residual, secants = np.inf, Secants()
        state = _State.at(energy, u)
        if not np.isfinite(state.energy):
            return None
        for _ in range(self.max_iterations):
            report.residual = float(np.linalg.norm(state.gradient)) / energy.force_scale(state.forces)
            report.energy, report.smallest_jacobian = state.energy, state.smallest_jacobian
            if report.residual <= self.tolerance:
                return state.u
            secants.visit(state.u.reshape(-1)[energy.free], state.gradient)
            contracts_well = level is not None and report.residual <= GOOD_CONTRACTION * last_residual
            following = _step(energy, state, secants) if contracts_well else None
            if following is None:
                if self.watch is not None:
                    self.watch(state.u)
                level = factorise(energy, state.u, max(level or 0, 1) - 1, report, rough=self.rough)
                if level is None:
                    return None
                secants.forget()
                following = _step(energy, state, secants)
            if following is None:
                return None
            report.iterations += 1
            state, last_residual = following, report.residual
        return None


def factorise(energy: Energy, u: FloatArray, level: int, report: SolverReport, *, rough: bool = False) -> int | None:
    """Factorise at the first of `PROJECTIONS` from a level on that is positive definite, and return its level."""
    tangents = energy.tangents(u)
    for trial in range(level, len(PROJECTIONS)):
        if trial == ONLY_OBSTACLES and not tangents.at_obstacles:
            continue
        report.factorisations += 1
        report.projections += trial > 0
        try:
            energy.factorise(*tangents.mixed(PROJECTIONS[trial]), rough=rough)
            return trial
        except NotPositiveDefiniteError:
            continue
    return None


@dataclass(frozen=True)
class _State:
    """A displacement u (n, 3) with its energy, smallest J, forces (n, 3) and their free components."""

    u: FloatArray
    energy: float
    smallest_jacobian: float
    forces: FloatArray
    gradient: FloatArray

    @classmethod
    def at(cls, energy: Energy, u: FloatArray) -> _State:
        value, smallest, forces = energy.forces(u)
        return cls(u, value, smallest, forces, forces.reshape(-1)[energy.free])


def _step(energy: Energy, state: _State, secants: Secants) -> _State | None:
    """One step with the factors at hand; None when it does not descend.

    Most steps go all their length: forces are taken with the energy, which is half of their cost, at once.
    """
    direction = np.zeros_like(state.u)
    flat = direction.reshape(-1)
    flat[energy.free] = -secants.solve(energy.solve, state.gradient)
    slope = float(state.gradient @ flat[energy.free])
    if slope >= 0.0:
        return None
    rounding = ENERGY_PRECISION * max(abs(state.energy), energy.energy_scale)
    length = energy.largest_step(state.u, direction)
    while length >= SMALLEST_STEP_LENGTH:
        trial = _State.at(energy, state.u + length * direction)
        if np.isfinite(trial.energy) and trial.energy <= state.energy + ARMIJO * length * slope + rounding:
            return trial
        length *= 0.5
    return None
