"""A hard case of the full model, how it is tried, and how what comes of it is judged without trusting the report."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from risorius.inputs import InputTable
from risorius.jaw import FloatArray
from risorius_offline.equilibrium import Equilibrium, EquilibriumSolver, NotConvergedError
from risorius_offline.full_model import FullModel
from risorius_offline.hard_solves import Judged, judge
from risorius_offline.linear_solver import NotPositiveDefiniteError
from risorius_offline.newton import SolverReport

Parameters: TypeAlias = Callable[[InputTable], FloatArray]

CONVERGES, REFUSED = "converges", "refused"


@dataclass(frozen=True)
class HardCase:
    """A model, the parameters to solve for, fields of the EquilibriumSolver, and the verdict to come.

    start: parameters of an equilibrium to start from instead of rest.
    """

    name: str
    build: Callable[[], FullModel]
    parameters: Parameters
    settings: Mapping[str, Any] = field(default_factory=dict)
    expect: str = CONVERGES
    start: Parameters | None = None


@dataclass(frozen=True)
class Attempt:
    """What a case came to: the equilibrium, None where it was refused; the solver's report; seconds with building."""

    found: Equilibrium | None
    report: SolverReport
    degrees_of_freedom: int
    seconds: float

    @property
    def outcome(self) -> str:
        return CONVERGES if self.found else REFUSED


def attempt(case: HardCase) -> Attempt:
    """Solve a case; every error but NotConvergedError passes."""
    begin = time.perf_counter()
    model = case.build()
    solver = EquilibriumSolver(model, **case.settings)
    inputs = model.anatomy.inputs
    start = EquilibriumSolver(model).solve(case.start(inputs)) if case.start else None
    try:
        found = solver.solve(case.parameters(inputs), start)
    except NotConvergedError as error:
        return Attempt(None, error.report, len(model.free), time.perf_counter() - begin)
    return Attempt(found, found.report, len(model.free), time.perf_counter() - begin)


def check(case: HardCase, model: FullModel, found: Equilibrium) -> Judged:
    """Judge an equilibrium at the parameters that were asked for, by a model that has not solved anything yet."""
    return judge(model, case.parameters(model.anatomy.inputs), found.u)


def is_stable(model: FullModel, u: FloatArray) -> bool:
    """Whether the true tangent is positive definite: the state is a minimum, not a saddle."""
    try:
        model.factorise(*model.tangent(u))
    except NotPositiveDefiniteError:
        return False
    return True
