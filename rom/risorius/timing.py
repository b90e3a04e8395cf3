"""How long frames take on this machine."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

from risorius.inputs import InputTable
from risorius.jaw import FloatArray
from risorius.pipeline import Pipeline

ROUND = 8  # frames of one pipeline after each other: caches are as warm as in use
SHARE, MARGIN = 0.9, 1.5


def dense_parameters(inputs: InputTable, count: int) -> FloatArray:
    """Parameters (count, p), each of them at a random weight: no input costs more."""
    lowest = inputs.parameter_lower
    return lowest + (1.0 - lowest) * np.random.default_rng(0).random((count, len(lowest)))


def frame_seconds(
    ways: Sequence[Pipeline],
    inputs: InputTable,
    vertices: int,
    frames: int,
    clock: Callable[[], float] = time.perf_counter,
) -> FloatArray:
    """Seconds (ways, frames) of whole frames. `frames` is a multiple of ROUND.

    All take turns, so that what else the machine does falls on all alike. The first frame of each turn does not count:
    it compiles kernels and fills caches.
    """
    out = np.empty((vertices, 3), np.float32)
    every = dense_parameters(inputs, frames)
    seconds = np.empty((len(ways), frames))
    for start in range(0, frames, ROUND):
        rows = every[start : start + ROUND]
        for way, row in zip(ways, seconds, strict=True):
            for number, parameters in enumerate([rows[0], *rows]):
                begin = clock()
                way.solve(parameters)
                way.write(out)
                row[start + max(number - 1, 0)] = clock() - begin
    return seconds


def cautious(seconds: FloatArray) -> FloatArray:
    """Seconds (ways,) that 99 % of frames keep, from few of them (ways, frames): a quantile with a margin.

    The longest of few frames would tell more of what else the machine did meanwhile.
    """
    return np.asarray(MARGIN * np.quantile(seconds, SHARE, axis=1))
