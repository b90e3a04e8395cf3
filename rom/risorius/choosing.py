"""Which of a model's operating points an engine runs."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterable, Sequence
from functools import partial

import numpy as np

from risorius.budget import Budget, Offer, choose
from risorius.jaw import FloatArray
from risorius.model import ReducedModel
from risorius.operating_point import OperatingPoint
from risorius.pipeline import Pipeline, pipelines
from risorius.timing import cautious, frame_seconds

FEW, SOME, MANY = 16, 128, 384
"""Frames by which a point is ruled out, compared with others, and trusted to keep a time."""
UNASKED, HARDLY_LONGER = 1e-3, 1.25
"""Seconds that an engine keeps to that was not given a budget; where no point does, so many times the fastest."""

_log = logging.getLogger(__name__)


def taken(model: ReducedModel, budget: Budget | None) -> tuple[OperatingPoint, Pipeline]:
    """Return one of the points of a model, and what runs it with the model's effects on this machine.

    With a budget all are timed here and now, by time of the processor: what else the machine does is not theirs.
    Without one, the times of training decide and nothing is timed, so that the same model always answers alike. A
    budget that no point meets gives the nearest, and a warning in the log.
    """
    points, effects = model.points, tuple(model.effects.values())
    if budget is None or budget == Budget():
        medians = [point.seconds.median for point in points]
        budget = Budget(time=max(UNASKED, HARDLY_LONGER * min(medians)))
        point = points[choose(_offers(points, medians), budget).position]
        return point, pipelines(model, [point.setting], effects)[0]
    ways = pipelines(model, [point.setting for point in points], effects)
    seconds = _cautious(ways, model, budget)
    choice = choose(_offers(points, seconds), budget)
    point = points[choice.position]
    if not choice.met:
        reached = ", ".join(f"{kind} {1e3 * found.frame:.3g} mm" for kind, found in point.errors.items())
        _log.warning(
            "budget of %s: no operating point of model %r keeps it here; the nearest, %s, takes up to %.3g ms, "
            "and 95 %% of its frames are within: %s",
            *(budget, model.name, point.setting, 1e3 * seconds[choice.position], reached),
        )
    return point, ways[choice.position]


def _cautious(ways: Sequence[Pipeline], model: ReducedModel, budget: Budget) -> FloatArray:
    """Seconds (ways,) that 99 % of frames keep; infinite for ways of which most of FEW frames break the budget.

    Where all do, from these alone.
    """
    taken_by = partial(frame_seconds, model=model, clock=time.thread_time)
    if budget.time is None:
        return cautious(taken_by(ways, frames=SOME))
    few = taken_by(ways, frames=FEW)
    kept = np.flatnonzero(np.median(few, axis=1) <= budget.time)
    if not len(kept):
        return cautious(few)
    seconds = np.full(len(ways), np.inf)
    seconds[kept] = cautious(taken_by([ways[int(way)] for way in kept], frames=MANY))
    return seconds


def _offers(points: Sequence[OperatingPoint], seconds: Iterable[float]) -> list[Offer]:
    return [Offer(float(cost), point.frame_error, point.p95) for point, cost in zip(points, seconds, strict=True)]
