"""The guard: coordinates that tissue can have pass; others are mended, or the last good ones are kept."""

from __future__ import annotations

import math
from enum import Enum

import numpy as np

from risorius.guard.folds import FOLDED, Folds
from risorius.guard.watch import Watch
from risorius.jaw import FloatArray
from risorius.sizes import length_squared

UNFOLDED = np.empty((0, 3))
"""No place where tissue was folded."""

FARTHEST = 4.0  # times the longest modal coordinates of an equilibrium: what is longer has exploded


class Verdict(Enum):
    """What became of a frame: as it was answered; changed until no watched point folds; the last good one instead."""

    GOOD = "good"
    MENDED = "mended"
    HELD = "held"


class Guard:
    """Judges the coordinates of a face. Not thread-safe: it keeps the last good ones.

    watch: points of the tissue, None where a model has none: then only what is not finite is stopped. lifts: leading
    coordinates that poses prescribe and that are never mended. size: number of all coordinates, those of effects last.
    folds: (f, 3) places at rest where tissue of the last frame was folded before it was mended, None where it was but
    nobody knows where.
    """

    def __init__(self, watch: Watch | None, lifts: int, size: int) -> None:
        face = size if watch is None else len(watch.gradients)
        self._all, self._modal = slice(0, face), slice(lifts, face)
        self._most = math.inf if watch is None else (FARTHEST * watch.longest) ** 2
        self._folds = None if watch is None else Folds(watch, lifts)
        self._last = np.zeros(size)
        self.folds: FloatArray | None = UNFOLDED

    def settle(self, coordinates: FloatArray) -> Verdict:
        """Judge coordinates (size,), and replace those that are not good."""
        self.folds = UNFOLDED
        verdict = self._judge(coordinates)
        if verdict is Verdict.HELD:
            coordinates[:] = self._last
        else:
            self._last[:] = coordinates
        return verdict

    def _judge(self, coordinates: FloatArray) -> Verdict:
        if not (length_squared(coordinates) < math.inf and length_squared(coordinates[self._modal]) <= self._most):
            return Verdict.HELD
        face = coordinates[self._all]
        if self._folds is None or self._folds.smallest(face) > FOLDED:
            return Verdict.GOOD
        folds = self._folds.places()
        if not self._folds.unfold(face):
            return Verdict.HELD
        self.folds = folds
        return Verdict.MENDED
