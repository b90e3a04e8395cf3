"""One sample of a sampling design, solved on a worker."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from risorius.errors import SolverError
from risorius.jaw import FloatArray
from risorius.snapshot_store import REPORT, Solved
from risorius_offline.equilibrium import Equilibrium, EquilibriumSolver
from risorius_offline.newton import SolverReport
from risorius_offline.sensitivities import gravity_sensitivities, sensitivities

# Of the last attempt: as many load steps from rest at least, each of which may still be halved.
SMALL_STEPS = 8


@dataclass(frozen=True)
class State:
    """Parameters (p,) of an equilibrium and its displacement (n, 3), single precision, as it is stored."""

    parameters: FloatArray
    displacement: npt.NDArray[np.float32]


@dataclass(frozen=True)
class Outcome:
    """What became of a sample: `solved` is None when it failed, and `failure` says why."""

    parameters: FloatArray
    solved: Solved | None
    report: dict[str, float]
    failure: str = ""

    @property
    def state(self) -> State | None:
        """The equilibrium, for others to start from."""
        return State(self.parameters, self.solved.displacement) if self.solved else None


@dataclass(frozen=True)
class SampleSolver:
    """Solves samples; derivatives: whether to find those of the displacement as well, by parameters and gravity."""

    solver: EquilibriumSolver
    derivatives: bool

    @cached_property
    def _rest(self) -> Equilibrium:
        return self.solver.rest()

    def solve(self, parameters: FloatArray, guess: npt.NDArray[np.float32] | None, states: Sequence[State]) -> Outcome:
        """Solve from a guess (n, 3) of the displacement; else from the nearest of `states`; else from rest.

        At last it is solved from rest in small steps.

        It does not raise SolverError: the outcome says what the last attempt met with.
        """
        begun = time.thread_time()
        failure, attempts = "", 0
        for attempt in self._attempts(parameters, guess, states):
            attempts += 1
            try:
                solved = self._solved(attempt())
                report = {**solved.report, "attempts": attempts, "seconds": time.thread_time() - begun}
                return Outcome(parameters, replace(solved, report=report), report)
            except (SolverError, np.linalg.LinAlgError, MemoryError) as error:
                failure = str(error) or type(error).__name__
        return Outcome(parameters, None, {"attempts": attempts, "seconds": time.thread_time() - begun}, failure)

    def _attempts(
        self, parameters: FloatArray, guess: npt.NDArray[np.float32] | None, states: Sequence[State]
    ) -> Iterator[Callable[[], Equilibrium]]:
        if guess is not None:
            yield lambda: self.solver.settle(parameters, guess.astype(np.float64))
        known = [self._rest, *(Equilibrium(s.parameters, s.displacement.astype(np.float64)) for s in states)]
        nearest = min(known, key=lambda state: float(np.linalg.norm(state.parameters - parameters)))
        if nearest is not self._rest:
            yield lambda: self.solver.solve(parameters, nearest)
        yield lambda: self.solver.solve(parameters, self._rest)
        yield lambda: self._in_small_steps(parameters)

    def _in_small_steps(self, parameters: FloatArray) -> Equilibrium:
        state = self._rest
        for share in np.arange(1, SMALL_STEPS + 1) / SMALL_STEPS:
            state = self.solver.solve(share * parameters, state)
        return state

    def _solved(self, found: Equilibrium) -> Solved:
        slopes = {"derivatives": sensitivities, "by_gravity": gravity_sensitivities} if self.derivatives else {}
        fields = {name: find(self.solver.model, found) for name, find in slopes.items()}
        return Solved.of(found.u, fields, _entries(found.report))


def _entries(report: SolverReport) -> dict[str, float]:
    return {name: value for name, value in asdict(report).items() if name in (REPORT.names or ())}
