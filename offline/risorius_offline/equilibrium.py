"""Static equilibria: continuation in muscle activation and jaw pose, each load step a guarded Newton minimisation.

Factors of single precision give directions for two thirds of the time. Where cells are near collapse they fail, and
early: there a smaller load step does better than factors of double precision, which are for where none does. The last
load step has to end in a minimum of the energy: from a saddle the solver goes on, down its unstable direction.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from risorius.errors import InputError, SolverError
from risorius.jaw import FloatArray
from risorius_offline.full_model import Contacts, FullModel
from risorius_offline.newton import GuardedNewton, SolverReport
from risorius_offline.prediction import Predictor
from risorius_offline.stability import way_down

# Load steps before the last only lead there.
TOLERANCE_ON_THE_WAY = 1e-1
# Of the whole way, what contact may shorten a load step to; shorter ones cost five times the iterations.
SHORTEST_FOLLOWED = 1.0 / 8.0
# Saddles that are left, one after the other, before a load step counts as failed.
MOST_SADDLES = 5
# Metres by which surfaces may be deeper in each other at an equilibrium than contact pairs have it. Those found there
# then take their place, so many times, and Newton's method goes on; a guess that is tangled by so much, or comes to be,
# is given up for a start that is not.
TOLERATED, TANGLED, MOST_UPDATES = 0.1e-3, 1e-3, 6
# A step that leaves less than this share of the way leaves nothing of it.
ROUNDING = 1e-9


class NotConvergedError(SolverError):
    """No equilibrium was found; `report` tells how far the solve came."""

    def __init__(self, message: str, report: SolverReport) -> None:
        super().__init__(message)
        self.report = report


@dataclass(frozen=True)
class Equilibrium:
    """A converged state: parameters (p,), displacement u (n, 3) in metres, report.

    contacts: the pairs that its forces rest on, as `FullModel.contacts`.
    """

    parameters: FloatArray
    u: FloatArray
    report: SolverReport = field(default_factory=SolverReport)
    contacts: Contacts = ()


@dataclass(frozen=True)
class EquilibriumSolver:
    """Finds equilibria of a full model.

    tolerance: norm of the free forces relative to muscle and reaction forces. max_iterations: per load step.
    smallest_step: of the continuation parameter, before giving up. watch: as of `GuardedNewton`, on a last load step.
    """

    model: FullModel
    tolerance: float = 1e-6
    max_iterations: int = 80
    smallest_step: float = 1.0 / 128.0
    watch: Callable[[FloatArray], None] | None = None

    def rest(self) -> Equilibrium:
        """The undeformed state, all parameters zero."""
        count = len(self.model.anatomy.inputs.parameters)
        return Equilibrium(np.zeros(count), np.zeros_like(self.model.anatomy.points))

    def solve(self, parameters: FloatArray, start: Equilibrium | None = None) -> Equilibrium:
        """Equilibrium at parameters (p,), reached from `start` (rest by default).

        A minimum of the energy; where the report does not say that it is stable, its least curvature is about zero.
        Raises InputError for parameters that are not p finite numbers, and NotConvergedError, which carries the report,
        when continuation comes down to its smallest step.
        """
        state = start or self.rest()
        target = self._checked(parameters)
        report = SolverReport()
        done, step, predictor, rough = 0.0, 1.0, None, True
        while done < 1.0:
            self.model.set_parameters(state.parameters)
            self.model.hold_contacts(self.model.search_contacts(state.u, state.contacts))
            step = self._followed(state, target, min(step, 1.0 - done), 1.0 - done)
            aim = _on_the_way(state.parameters, target, step / (1.0 - done))
            predictor = predictor or Predictor(self.model, state.u, state.parameters, report)
            guess, u, at_the_end = predictor.predict(aim), None, aim is target
            if guess is not None:
                level = 0 if self.model.factorised_for is state else None
                find = self._minimum if at_the_end else self._on_the_way
                u, predictor = find(guess, report, level, rough=rough), None
            if u is not None:
                state = Equilibrium(aim, u)
                done = 1.0 if at_the_end else done + step
                step *= 2.0
                report.steps += 1
                continue
            report.rejected_steps += 1
            step *= 0.5
            if step < self.smallest_step and rough:
                rough, step = False, 1.0
            if step < self.smallest_step:
                raise NotConvergedError(
                    f"no equilibrium beyond {100 * done:.1f} % of the way to {self._describe(target)}: "
                    f"residual {report.residual:.1e}, smallest J {report.smallest_jacobian:.3f} after "
                    f"{report.iterations} iterations; lower the activations or the jaw weight",
                    report,
                )
        return self._told(state, report)

    def settle(self, parameters: FloatArray, guess: FloatArray) -> Equilibrium:
        """Equilibrium at parameters (p,) beside a guess (n, 3) of its displacement.

        Raises InputError as `solve` does, and NotConvergedError when no equilibrium is in reach.
        """
        target, report = self._checked(parameters), SolverReport(steps=1)
        start = self._towards(guess, target)
        found = None if start is None else self._minimum(start, report, None, rough=True, most_missed=TANGLED)
        if found is None:
            raise NotConvergedError(f"no equilibrium beside a guess at {self._describe(target)}", report)
        return self._told(Equilibrium(target, found), report)

    def _towards(self, guess: FloatArray, target: FloatArray) -> FloatArray | None:
        """The guess (n, 3), bones where the target has them, mended if need be; None where it cannot be.

        What is behind other surfaces there is not paired: a guess errs in hundreds of places, an equilibrium in few.
        """
        self.model.set_parameters(target)
        bones = self.model.prescribed_motion(target)
        start = self.model.admissible(np.where(self.model.anatomy.prescribed[:, None], bones, guess))
        self.model.hold_contacts(())
        if start is None or self.model.missed_depth(start, self.model.search_contacts(start)) > TANGLED:
            return None
        return start

    def _told(self, state: Equilibrium, report: SolverReport) -> Equilibrium:
        """A state with the report of its solve; the model is told of it, if it is a minimum: it holds its factors."""
        report.converged = True
        found = replace(state, report=report, contacts=self.model.contacts)
        if report.stable:
            self.model.factorised_for = found
        return found

    def _on_the_way(self, u: FloatArray, report: SolverReport, level: int | None, *, rough: bool) -> FloatArray | None:
        newton = GuardedNewton(max(self.tolerance, TOLERANCE_ON_THE_WAY), self.max_iterations, rough)
        return newton.minimise(self.model, u, report, level)

    def _minimum(
        self,
        u: FloatArray,
        report: SolverReport,
        level: int | None,
        *,
        rough: bool,
        most_missed: float = math.inf,
    ) -> FloatArray | None:
        """As `GuardedNewton.minimise`, past saddles and with all that touches; factors are then of the tangent there.

        None, too, where surfaces come to lie so many metres deeper in each other than contact pairs have it.
        """
        newton = GuardedNewton(self.tolerance, self.max_iterations, rough, self.watch)
        saddles, updates = 0, 0
        while saddles <= MOST_SADDLES:
            found = newton.minimise(self.model, u, report, level)
            if found is None:
                return None
            contacts = self.model.search_contacts(found)
            missed = self.model.missed_depth(found, contacts)
            if missed > most_missed:
                return None
            if missed > TOLERATED and updates < MOST_UPDATES:
                self.model.hold_contacts(contacts)
                u, level, updates = found, None, updates + 1
                continue
            lower = way_down(self.model, found, report)
            if lower is None:
                return found
            u, level, saddles = lower, None, saddles + 1
        return None

    def _checked(self, parameters: FloatArray) -> FloatArray:
        """Return a copy, which an equilibrium keeps whatever the caller does with the original."""
        array, names = np.array(parameters, dtype=np.float64), self.model.anatomy.inputs.parameters
        if array.shape != (len(names),):
            raise InputError(f"parameters have shape {array.shape}; give {len(names)}: {', '.join(names)}")
        for name, value in zip(names, array, strict=True):
            if not math.isfinite(value):
                raise InputError(f"parameter {name} is {value}; give a finite number")
        return array

    def _followed(self, state: Equilibrium, target: FloatArray, step: float, left: float) -> float:
        """Shorten a step to what surfaces let the tissue follow at once: what lags behind the bones is torn.

        Not below `SHORTEST_FOLLOWED`: where surfaces touch they admit next to nothing, and tissue recovers from a tear.
        """
        aim = _on_the_way(state.parameters, target, step / left)
        share = self.model.followed_share(state.u, state.parameters, aim)
        return min(step, max(share * step, SHORTEST_FOLLOWED, self.smallest_step))

    def _describe(self, parameters: FloatArray) -> str:
        names = self.model.anatomy.inputs.parameters
        return (
            ", ".join(f"{name} = {value:g}" for name, value in zip(names, parameters, strict=True) if value) or "rest"
        )


def _on_the_way(start: FloatArray, target: FloatArray, share: float) -> FloatArray:
    """Parameters at a share of the way; the target itself at the end of it."""
    return target if share > 1.0 - ROUNDING else start + share * (target - start)
