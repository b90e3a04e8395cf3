"""How long frames take on this machine."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

from risorius.jaw import FloatArray
from risorius.model import ReducedModel
from risorius.pipeline import Pipeline

ROUND = 8  # frames of one pipeline after each other: caches are as warm as in use
AT_WORK = 4  # inputs in the mean, in every second frame
SHARE, MARGIN = 0.75, 2.0


def frame_seconds(
    ways: Sequence[Pipeline], model: ReducedModel, frames: int, clock: Callable[[], float] = time.perf_counter
) -> FloatArray:
    """Seconds (ways, frames) from weights to vertices, with every input in use and with few of them in turn.

    With all the map has most to do, with few contact: lips that are nearly closed. frames: a multiple of ROUND. All
    take turns, so that what else the machine does falls on all alike. The first frame of each turn does not count: it
    compiles kernels and fills caches.
    """
    weights = random_weights(model.inputs.lower, frames)
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


def random_weights(lowest: FloatArray, frames: int) -> FloatArray:
    """Weights (frames, inputs) at random between lowest (inputs,) and 1, of every second row but AT_WORK or so 0."""
    rng = np.random.default_rng(0)
    weights = lowest + (1.0 - lowest) * rng.random((frames, len(lowest)))
    weights[::2] *= rng.random((len(weights[::2]), len(lowest))) * len(lowest) < AT_WORK
    return weights


def _frame(way: Pipeline, model: ReducedModel, weights: FloatArray) -> None:
    way.solve(model.inputs.to_parameters(model.inputs.checked(weights)))
    way.write(np.empty_like(model.rest_vertices))


def cautious(seconds: FloatArray) -> FloatArray:
    """Seconds (ways,) that 99 % of frames keep, from few of them (ways, frames): SHARE of them take MARGIN times less.

    Or all as long, where some frames have more to do than others: of 384 one takes longer than 99 % of all would, with
    a probability of 98 %.
    """
    return np.asarray(np.maximum(MARGIN * np.quantile(seconds, SHARE, axis=1), seconds.max(axis=1)))
