"""Errors on held-out snapshots, and times of many frames, of all candidates in turn."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from risorius.jaw import FloatArray
from risorius.report.candidates import Candidate, Vertices
from risorius.report.held_out import HeldOutSet

FRAMES = 2000
WARM_UP = 20
# Frames of one candidate in a row: enough to have its tables in the cache, as they are in use.
TURN = 50


@dataclass(frozen=True)
class Errors:
    """Over all visible vertices of a set, metres against the full model; relative: median of the L2 errors."""

    mean: float
    p95: float
    maximum: float
    relative: float


@dataclass(frozen=True)
class Times:
    """Seconds by the clock of one thread."""

    median: float
    p99: float


def errors_on(candidate: Candidate, held_out: HeldOutSet, rest: Vertices) -> Errors:
    """Errors of a candidate's vertices; rest: (n, 3) vertices at rest."""
    errors = np.empty(held_out.vertices.shape[:2])
    lengths = np.empty(len(errors))
    for row, (parameters, truth) in enumerate(zip(held_out.parameters, held_out.vertices, strict=True)):
        difference = candidate.vertices(parameters).astype(np.float64) - truth
        errors[row] = np.linalg.norm(difference, axis=1)
        lengths[row] = np.linalg.norm(truth.astype(np.float64) - rest)
    relative = np.linalg.norm(errors, axis=1) / lengths
    return Errors(
        mean=float(errors.mean()),
        p95=float(np.quantile(errors, 0.95)),
        maximum=float(errors.max()),
        relative=float(np.median(relative)),
    )


def frames_like(parameters: FloatArray, lowest: FloatArray, count: int = FRAMES) -> FloatArray:
    """Inputs (count, p) with the patterns of those given (s, p): the same ones act, each by -20 to 20 % otherwise."""
    rng = np.random.default_rng(0)
    rows = rng.integers(0, len(parameters), count)
    return np.clip(parameters[rows] * rng.uniform(0.8, 1.2, (count, parameters.shape[1])), lowest, 1.0)


def times_of(candidates: Sequence[Candidate], inputs: FloatArray) -> dict[str, tuple[Times, Times]]:
    """Times to coordinates and of the whole frame for every candidate, over inputs (f, p)."""
    actions: dict[tuple[str, str], Callable[[FloatArray], object]] = {}
    for candidate in candidates:
        actions[candidate.name, "coordinates"] = candidate.coordinates
        actions[candidate.name, "vertices"] = candidate.vertices
    found = in_turn(actions, inputs)
    return {one.name: (found[one.name, "coordinates"], found[one.name, "vertices"]) for one in candidates}


def in_turn(
    actions: Mapping[tuple[str, str], Callable[[FloatArray], object]], inputs: FloatArray
) -> dict[tuple[str, str], Times]:
    """Times of actions that take turns, A B C A B C: what else the machine does falls on all of them alike."""
    for action in actions.values():
        for parameters in inputs[:WARM_UP]:
            action(parameters)
    seconds = {name: np.empty(len(inputs)) for name in actions}
    for start in range(0, len(inputs), TURN):
        for name, action in actions.items():
            _time(action, inputs[start : start + TURN], seconds[name][start : start + TURN])
    return {name: Times(float(np.median(own)), float(np.quantile(own, 0.99))) for name, own in seconds.items()}


def _time(action: Callable[[FloatArray], object], inputs: FloatArray, out: FloatArray) -> None:
    clock = time.perf_counter
    for number, parameters in enumerate(inputs):
        begin = clock()
        action(parameters)
        out[number] = clock() - begin
