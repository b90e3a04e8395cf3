"""All cases, run one after another."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from risorius.gauntlet.acting import acting_cases
from risorius.gauntlet.adversary import adversarial_cases
from risorius.gauntlet.case import Bench, Case, NotApplicableError
from risorius.gauntlet.extremes import extreme_cases
from risorius.gauntlet.judge import Judge
from risorius.gauntlet.numbers import number_cases
from risorius.gauntlet.sequences import sequence_cases
from risorius.gauntlet.settings import setting_cases
from risorius.gauntlet.streams import stream_cases
from risorius.model import ReducedModel

PASSED, FAILED, NOT_APPLICABLE = "passed", "failed", "not applicable"


@dataclass(frozen=True)
class Result:
    """What a case came to. detail: verdicts that are broken and in how many frames, or what the model lacks.

    smallest_jacobian: of converged frames at the watched points, None where there are none. farthest: metres that a
    vertex moves; deepest: metres that skin is in teeth or in the other lip.
    """

    name: str
    group: str
    outcome: str
    detail: str = ""
    frames: int = 0
    refused: int = 0
    mended: int = 0
    held: int = 0
    went_back: int = 0
    smallest_jacobian: float | None = None
    farthest: float = 0.0
    deepest: float = 0.0


def all_cases() -> list[Case]:
    """Every case of any reduced model."""
    return [
        *extreme_cases(),
        *sequence_cases(),
        *acting_cases(),
        *setting_cases(),
        *number_cases(),
        *stream_cases(),
        *adversarial_cases(),
    ]


def run(model: ReducedModel, cases: Iterable[Case]) -> Iterator[Result]:
    """Result after result."""
    bench = Bench(model)
    for case in cases:
        yield _result(case, bench)


def _result(case: Case, bench: Bench) -> Result:
    try:
        varied = case.variant(bench)
        asked = list(case.frames(varied))
    except NotApplicableError as error:
        return Result(case.name, case.group, NOT_APPLICABLE, str(error))
    judge = Judge(varied)
    for ask in asked:
        judge.take(ask)
    judge.finish()
    broken = {name: count for name, count in judge.broken.items() if count}
    return Result(
        name=case.name,
        group=case.group,
        outcome=FAILED if broken else PASSED,
        detail=", ".join(f"{name}: {count}" for name, count in broken.items()),
        frames=judge.frames,
        refused=judge.refused,
        mended=judge.mended,
        held=judge.held,
        went_back=judge.went_back,
        smallest_jacobian=judge.smallest_jacobian,
        farthest=judge.farthest,
        deepest=judge.deepest,
    )
