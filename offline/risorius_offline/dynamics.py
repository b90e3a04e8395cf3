"""Motion of a full model: (7.1) with the true elastic forces, integrated implicitly.

    M a + C v + dE/du = 0

A step is the singly diagonally implicit Runge-Kutta method of two stages and second order that damps what it does not
resolve (Alexander 1977): with gamma = 1 - 1/sqrt(2), each stage is backward Euler over gamma h,

    u_1 = u + gamma h v_1,                            v_1 = v + gamma h a_1
    u_2 = u + (1 - gamma) h v_1 + gamma h v_2,        v_2 = v + (1 - gamma) h a_1 + gamma h a_2

and the second stage is the end of the step. A small vibration never gains energy, however long the step is (|R| <= 1 on
the imaginary axis); large ones are measured in the tests.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.equilibrium import EquilibriumSolver, NotConvergedError
from risorius_offline.full_model import FullModel
from risorius_offline.inertia import Inertia, Medium
from risorius_offline.newton import GuardedNewton, SolverReport
from risorius_offline.time_stage import Motion, StageEnergy

GAMMA = 1.0 - np.sqrt(0.5)


@dataclass(frozen=True)
class MotionState:
    """A moment: time (s), parameters (p,), u (n, 3) in metres, velocity (n, 3) in m/s, energies in joules, report.

    potential_energy is that of the model: tissue, muscles at their present activation, effects. The report is of the
    solves since the state before; its steps are time steps, its energy that of the last stage.
    """

    time: float
    parameters: FloatArray
    u: FloatArray
    velocity: FloatArray
    potential_energy: float
    kinetic_energy: float
    report: SolverReport


@dataclass(frozen=True)
class MotionSolver:
    """Follows the motion of a full model.

    tolerance: norm of the free forces relative to the forces that balance. max_iterations: per stage of a time step.
    smallest_fraction: of the step asked for, before giving up.
    """

    model: FullModel
    medium: Medium = field(default_factory=Medium)
    tolerance: float = 1e-6
    max_iterations: int = 80
    smallest_fraction: float = 1.0 / 128.0

    def simulate(
        self, parameters: FloatArray, step: float, u: FloatArray | None = None, velocity: FloatArray | None = None
    ) -> Iterator[MotionState]:
        """States at the times 0, step, 2 step, ... of parameters (t, p) given at these times, linear in between.

        u (n, 3): displacement to start from, the equilibrium at the first parameters by default; velocity (n, 3) in
        m/s, zero by default. step in seconds. A time step that does not converge is made of shorter ones; raises
        NotConvergedError, which carries the report, when they come down to `smallest_fraction`.
        """
        parameters = np.asarray(parameters, dtype=np.float64)
        count = len(self.model.anatomy.inputs.parameters)
        if parameters.ndim != 2 or parameters.shape[1] != count or not len(parameters):
            raise InputError(f"motion: parameters have shape {parameters.shape}; give a row of {count} for each time")
        if not step > 0.0:
            raise InputError(f"motion: time step {step:g} s; give a positive one")
        if u is None:
            u = EquilibriumSolver(self.model, self.tolerance, self.max_iterations).solve(parameters[0]).u
        return self._follow(parameters, step, Motion(u, np.zeros_like(u) if velocity is None else velocity))

    def _follow(self, parameters: FloatArray, step: float, motion: Motion) -> Iterator[MotionState]:
        self.model.set_parameters(parameters[0])
        yield self._state(0.0, parameters[0], motion, SolverReport(converged=True))
        for number in range(1, len(parameters)):
            motion, report = self._advance(motion, parameters[number - 1], parameters[number], step)
            yield self._state(number * step, parameters[number], motion, report)

    def _advance(
        self, motion: Motion, before: FloatArray, after: FloatArray, step: float
    ) -> tuple[Motion, SolverReport]:
        """Move on from parameters `before` to `after`, in as many parts as it takes."""
        report = SolverReport()
        done, fraction, start = 0.0, 1.0, before
        while done < 1.0:
            fraction = min(fraction, 1.0 - done)
            aim = after if done + fraction == 1.0 else before + (done + fraction) * (after - before)
            following = self._time_step(motion, start, aim, fraction * step, report)
            if following is not None:
                motion, start = following, aim
                done += fraction
                fraction *= 2.0
                report.steps += 1
                continue
            report.rejected_steps += 1
            fraction *= 0.5
            if fraction < self.smallest_fraction:
                raise NotConvergedError(
                    f"no motion beyond {100 * done:.1f} % of a time step of {1e3 * step:g} ms: residual "
                    f"{report.residual:.1e}, smallest J {report.smallest_jacobian:.3f} after {report.iterations} "
                    "iterations; take shorter time steps or change the parameters less fast",
                    report,
                )
        report.converged = True
        return motion, report

    def _time_step(
        self, motion: Motion, before: FloatArray, after: FloatArray, step: float, report: SolverReport
    ) -> Motion | None:
        """Both stages; None when one of them does not converge."""
        self.model.hold_contacts(self.model.search_contacts(motion.u))
        stage, rest = GAMMA * step, (1.0 - GAMMA) * step
        between = before + GAMMA * (after - before)
        stiffness = self._damping_stiffness(motion, step)
        guesses = self._guesses(motion, before, between, stage)
        first = self._stage(motion, between, stage, stiffness, guesses, report)
        if first is None:
            return None
        acceleration = (first.velocity - motion.velocity) / stage
        anchor = Motion(motion.u + rest * first.velocity, motion.velocity + rest * acceleration)
        guesses = self._guesses(first, between, after, rest)
        return self._stage(anchor, after, stage, stiffness, guesses, report)

    def _damping_stiffness(self, motion: Motion, step: float) -> FloatArray:
        """Stiffness of the tissue half a time step ahead, which keeps the second order; now, if that is inverted."""
        ahead = motion.u + 0.5 * step * motion.velocity
        admissible = np.isfinite(self.model.tissue.energy(ahead)[0])
        return self.model.passive_stiffness(ahead if admissible else motion.u, project=True)

    def _guesses(
        self, motion: Motion, before: FloatArray, after: FloatArray, time: float
    ) -> tuple[FloatArray, FloatArray]:
        """Where the tissue may be a time later: where it is now, or flown on with its velocity. Bones have moved."""
        staying = self.model.follow_bones(motion.u, before, after)
        direction = np.zeros_like(staying)
        direction.reshape(-1)[self.model.free] = time * motion.velocity.reshape(-1)[self.model.free]
        return staying, staying + self.model.largest_step(staying, direction) * direction

    def _stage(
        self,
        anchor: Motion,
        parameters: FloatArray,
        time: float,
        stiffness: FloatArray,
        guesses: tuple[FloatArray, ...],
        report: SolverReport,
    ) -> Motion | None:
        """Backward Euler over a time from an anchor; None when it does not converge."""
        self.model.set_parameters(parameters)
        energy = StageEnergy(self.model, self._inertia, stiffness, anchor, 1.0 / time)
        newton = GuardedNewton(self.tolerance, self.max_iterations)
        u = newton.minimise(energy, min(guesses, key=energy.energy), report)
        return None if u is None else energy.motion(u)

    def _state(self, time: float, parameters: FloatArray, motion: Motion, report: SolverReport) -> MotionState:
        potential, kinetic = self.model.energy(motion.u), self._inertia.kinetic_energy(motion.velocity)
        return MotionState(time, parameters, motion.u, motion.velocity, potential, kinetic, report)

    @cached_property
    def _inertia(self) -> Inertia:
        return Inertia(self.model.discretisation, self.medium)
