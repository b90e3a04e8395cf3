"""Inputs made to hurt: found by search, for the state that is worst by a measure."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from risorius.evaluators import CorrectedMap
from risorius.gauntlet.case import Ask, Bench, Case, NotApplicableError, asks
from risorius.jaw import FloatArray

STARTS, CHANGES = 100, 200
SHARES = (0.1, 0.3, 1.0)
SEEDS = (0, 1)

Measure = Callable[[FloatArray, FloatArray], float]
"""Of parameters (p,) and coordinates (lifts + modes,) as the evaluator gives them, before any guard."""


def adversarial_cases() -> list[Case]:
    """The worst found for each measure, from two starts."""
    measures = {
        "most folded": _folding,
        "longest residual": _residual,
        "largest coordinates": _length,
        "largest single coordinate": _largest,
    }
    return [
        Case(f"{name}, search {seed + 1}", "adversarial", partial(_attack, measure, seed))
        for name, measure in measures.items()
        for seed in SEEDS
    ]


def _folding(bench: Bench) -> Measure:
    watch = bench.model.watch
    if watch is None:
        raise NotApplicableError("no watched points")
    return lambda parameters, state: -float(watch.jacobians(state).min())


def _residual(bench: Bench) -> Measure:
    corrected = bench.model.evaluators.get(CorrectedMap.name)
    if not isinstance(corrected, CorrectedMap):
        raise NotApplicableError("no reduced physics")
    return corrected.residual


def _length(bench: Bench) -> Measure:
    return lambda parameters, state: float(np.linalg.norm(state[bench.model.lifts :]))


def _largest(bench: Bench) -> Measure:
    return lambda parameters, state: float(np.abs(state[bench.model.lifts :]).max())


def _attack(measure: Callable[[Bench], Measure], seed: int, bench: Bench) -> list[Ask]:
    """The worst of random inputs, made worse a few inputs at a time; shown between frames of rest."""
    rng, badness = np.random.default_rng(seed), partial(_badness, bench, measure(bench))
    starts = [bench.random(int(rng.integers(1 << 30)), SHARES[k % len(SHARES)], 1)[0] for k in range(STARTS)]
    worst = max(starts, key=badness)
    highest, path = badness(worst), [worst]
    for _ in range(CHANGES):
        tried, changed = worst.copy(), rng.integers(0, len(worst), rng.integers(1, 4))
        tried[changed] = np.clip(rng.uniform(bench.lower[changed] - 0.5, 1.5), bench.lower[changed], 1.0)
        found = badness(tried)
        if found > highest:
            worst, highest = tried, found
            path.append(worst)
    none = np.zeros_like(worst)
    return asks([*path, none, worst, none, worst])


def _badness(bench: Bench, measure: Measure, weights: FloatArray) -> float:
    model, setting = bench.model, bench.engine.point.setting
    parameters = model.inputs.to_parameters(weights)
    state = np.zeros(model.rank)
    model.poses.lift_coordinates(parameters[len(model.inputs.muscles) :], out=state[: model.lifts])
    modal = np.empty(setting.rank)
    bench.evaluator.coordinates(parameters, modal)
    state[model.lifts : model.lifts + setting.rank] = modal
    return measure(parameters, state)
