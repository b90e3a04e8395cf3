"""How long frames take on this machine."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

from risorius.jaw import FloatArray
from risorius.model import ReducedModel
from risorius.pipeline import Pipeline

ROUND = 8  # frames of one pipeline after each other: caches are as warm as in use
SHARE, MARGIN, MOST = 0.75, 2.0, 0.99


def frame_seconds(
    ways: Sequence[Pipeline], model: ReducedModel, frames: int, clock: Callable[[], float] = time.perf_counter
) -> FloatArray:
    """Seconds (ways, frames) from weights to vertices with every input in use: no frame costs more.

    frames: a multiple of ROUND. All take turns, so that what else the machine does falls on all alike. The first frame
    of each turn does not count: it compiles kernels and fills caches.
    """
    lowest = model.inputs.lower
    weights = lowest + (1.0 - lowest) * np.random.default_rng(0).random((frames, len(lowest)))
    seconds = np.empty((len(ways), frames))
    for start in range(0, frames, ROUND):
        turn = weights[start : start + ROUND]
        for way, row in zip(ways, seconds, strict=True):
            _frame(way, model, turn[0])
            for number, asked in enumerate(turn, start):
                begin = clock()
                _frame(way, model, asked)
                row[number] = clock() - begin
    return seconds


def _frame(way: Pipeline, model: ReducedModel, weights: FloatArray) -> None:
    way.solve(model.inputs.to_parameters(model.inputs.checked(weights)))
    way.write(np.empty_like(model.rest_vertices))


def cautious(seconds: FloatArray) -> FloatArray:
    """Seconds (ways,) that 99 % of frames keep, from few of them (ways, frames): SHARE of them take MARGIN times less.

    Or MOST of them as long, where some frames have more to do than others.
    """
    return np.asarray(np.maximum(MARGIN * np.quantile(seconds, SHARE, axis=1), np.quantile(seconds, MOST, axis=1)))
