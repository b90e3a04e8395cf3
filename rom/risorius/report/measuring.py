"""Times of many frames, of all candidates in turn."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from risorius.jaw import FloatArray

Action: TypeAlias = Callable[[FloatArray], object]

WARM_UP = 20
# Frames of one action in a row: enough to have its tables in the cache, as they are in use.
TURN = 50


@dataclass(frozen=True)
class Times:
    """Seconds by the clock, of one frame."""

    median: float
    p99: float


def in_turn(actions: Mapping[str, Action], inputs: FloatArray) -> dict[str, Times]:
    """Times of actions over inputs (f, p), A B C A B C: what else the machine does falls on all of them alike."""
    for action in actions.values():
        for parameters in inputs[:WARM_UP]:
            action(parameters)
    seconds = {name: np.empty(len(inputs)) for name in actions}
    for start in range(0, len(inputs), TURN):
        part = slice(start, start + TURN)
        for name, action in actions.items():
            seconds[name][part] = _seconds(action, inputs[part])
    return {name: Times(float(np.median(own)), float(np.quantile(own, 0.99))) for name, own in seconds.items()}


def _seconds(action: Action, inputs: FloatArray) -> list[float]:
    clock, result = time.perf_counter, []
    for parameters in inputs:
        begin = clock()
        action(parameters)
        result.append(clock() - begin)
    return result
