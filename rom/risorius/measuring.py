"""Operating points of a model: which there are, and how accurate and fast each is."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from risorius.accuracy import HeldOut
from risorius.error_bound import ErrorBound
from risorius.evaluators import CorrectedMap, NetworkMap, PolynomialMap, RationalMap, Setting, Superposition
from risorius.model import ReducedModel
from risorius.operating_point import OperatingPoint, Seconds
from risorius.pipeline import Pipeline, pipelines
from risorius.timing import frame_seconds

STEPS = (1, 2)  # of a correction
FRAMES = 320


def settings(model: ReducedModel) -> list[Setting]:
    """Return what training measures, of evaluators that the model has; a further setting is one line here.

    Fewer modes are cheaper to evaluate and to add up; where others err most, they would save next to nothing.
    """
    rank = model.rank - model.lifts
    corrected = model.evaluators.get(CorrectedMap.name)
    elements = corrected.elements if isinstance(corrected, CorrectedMap) else 0
    leading = tuple(dict.fromkeys((rank, max(rank // 2, 1), max(rank // 4, 1))))
    wanted = [
        Setting(Superposition.name, rank),
        Setting(PolynomialMap.name, rank),
        *(Setting(method, kept) for method in (RationalMap.name, NetworkMap.name) for kept in leading),
        *(Setting(CorrectedMap.name, rank, elements, steps) for steps in STEPS),
    ]
    return [setting for setting in wanted if setting.method in model.evaluators]


def measured(model: ReducedModel, held: HeldOut, wanted: Sequence[Setting]) -> tuple[OperatingPoint, ...]:
    """Operating points of a model with all its effects, on held-out snapshots and on this machine.

    Times are of the processor: what else the machine does while a model is trained must not tell what it takes later.
    """
    ways = pipelines(model, wanted, tuple(model.effects.values()))
    seconds = frame_seconds(ways, model, FRAMES, clock=time.thread_time)
    return tuple(
        _point(model, held, setting, way, Seconds(float(np.median(row)), float(np.quantile(row, 0.99))))
        for setting, way, row in zip(wanted, ways, seconds, strict=True)
    )


def _point(model: ReducedModel, held: HeldOut, setting: Setting, way: Pipeline, seconds: Seconds) -> OperatingPoint:
    indicators = np.array([way.solve(parameters) for parameters in held.parameters])
    errors = held.errors(_displacements(model, held, way))
    return OperatingPoint(
        setting=setting,
        errors=held.by_kind(errors),
        overall=held.overall(errors),
        seconds=seconds,
        bound=ErrorBound.fit(indicators, errors.max(axis=1).astype(np.float64)),
    )


def _displacements(model: ReducedModel, held: HeldOut, way: Pipeline) -> Iterator[npt.NDArray[np.float32]]:
    """Displacement (v, 3) in each held-out snapshot; the next one overwrites it."""
    vertices = np.empty_like(model.rest_vertices)
    for parameters in held.parameters:
        way.solve(parameters)
        way.write(vertices)
        yield vertices - model.rest_vertices
