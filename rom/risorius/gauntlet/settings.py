"""A model run with next to nothing: few modes, few steps, a tenth of its elements."""

from __future__ import annotations

from functools import partial

from risorius.evaluators import CorrectedMap, NetworkMap, PolynomialMap, RationalMap, Setting, Superposition
from risorius.gauntlet.case import Ask, Bench, Case, NotApplicableError, asks

FRAMES = 60
PARTS = {"rank 1": 0.0, "rank 2": 2.0, "a tenth of the modes": 0.1, "a quarter of the modes": 0.25,
         "half of the modes": 0.5, "all modes": 1.0}  # fmt: skip
STEPS = (1, 2, 8)
STARVED = 10


def setting_cases() -> list[Case]:
    """Strong random frames at every setting."""
    cases = [
        Case(f"{method}: {name}", "settings", _strong, partial(_ranked, method, part))
        for method in (Superposition.name, PolynomialMap.name, RationalMap.name, NetworkMap.name)
        for name, part in PARTS.items()
    ]
    cases += [
        Case(f"reduced physics: {steps} steps", "settings", _strong, partial(_corrected, steps)) for steps in STEPS
    ]
    cases.append(Case("reduced physics: a tenth of the elements", "settings", _strong, _starved))
    return cases


def _strong(bench: Bench) -> list[Ask]:
    return asks(bench.random(3, 0.5, FRAMES))


def _ranked(method: str, part: float, bench: Bench) -> Bench:
    rank = int(part) if part > 1.0 else max(round(part * bench.rank), 1)
    return bench.running(Setting(method, min(rank, bench.rank)))


def _corrected(steps: int, bench: Bench) -> Bench:
    corrected = bench.model.evaluators.get(CorrectedMap.name)
    if not isinstance(corrected, CorrectedMap):
        raise NotApplicableError("no reduced physics")
    return bench.running(Setting(CorrectedMap.name, bench.rank, corrected.elements, steps))


def _starved(bench: Bench) -> Bench:
    corrected = bench.model.evaluators.get(CorrectedMap.name)
    if not isinstance(corrected, CorrectedMap):
        raise NotApplicableError("no reduced physics")
    return bench.having(corrected.thinned(STARVED)).running(
        Setting(CorrectedMap.name, bench.rank, corrected.elements // STARVED, 2)
    )
