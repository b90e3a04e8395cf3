"""The error that every frame states: an upper bound of the largest distance of a vertex to the full model.

Indicators that a frame has anyway are turned into a length by a product of powers, fitted to held-out snapshots, and
raised until it covers new frames (conformal prediction with residuals out of fold, Vovk 2015).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np
from scipy.optimize import nnls

from risorius.accuracy import conformal_quantile
from risorius.jaw import FloatArray

INDICATORS = ("activity", "interaction", "tail", "doubt")
SMALLEST = 1e-3  # of an indicator: less does not tell frames apart
HALF_ACTIVE = 0.3  # weight at which a parameter counts half
LEAST_ERROR = 1e-9  # metres, below the rounding of vertices in single precision
FOLDS = 5
FRAMES_EACH = 4  # of an exponent: fewer held-out frames do not tell powers, and the bound is a constant


@dataclass(frozen=True)
class ErrorBound:
    """Metres: scale * product of (1 + indicator / SMALLEST) ** exponent; exponents are not negative.

    Exponents (4,) are those of INDICATORS: how many parameters act; size of what the evaluator adds to superposition;
    size of the upper half of the coordinates, which tells what the left-out modes would have been; and what the
    evaluator itself knows of its error.
    """

    scale: float
    exponents: tuple[float, ...]

    def value(self, indicators: tuple[float, ...]) -> float:
        """Bound of a frame; infinite where an indicator is not a number."""
        logarithm = math.log(self.scale)
        for exponent, indicator in zip(self.exponents, indicators, strict=True):
            logarithm += exponent * math.log1p(indicator / SMALLEST) if indicator >= 0.0 else math.inf
        return math.exp(logarithm) if logarithm < 700.0 else math.inf

    @classmethod
    def fit(cls, indicators: FloatArray, errors: FloatArray) -> ErrorBound:
        """Calibrate on the indicators (h, 4) and largest errors (h,), metres, of held-out snapshots."""
        logs = np.log1p(indicators / SMALLEST)
        targets = np.log(np.maximum(errors, LEAST_ERROR))
        exponents, constant = _powers(logs, targets)
        shift = conformal_quantile(_out_of_fold(logs, targets))
        return cls(math.exp(constant + shift), tuple(float(one) for one in exponents))


def _out_of_fold(logs: FloatArray, targets: FloatArray) -> FloatArray:
    """Residuals (h,) of fits that did not see them; a single one is seen."""
    residuals = np.empty(len(targets))
    fold = np.arange(len(targets)) % FOLDS
    for k in set(fold):
        missed = fold == k
        seen = missed if missed.all() else ~missed
        exponents, constant = _powers(logs[seen], targets[seen])
        residuals[missed] = targets[missed] - logs[missed] @ exponents - constant
    return residuals


def _powers(logs: FloatArray, targets: FloatArray) -> tuple[FloatArray, float]:
    """Exponents (k,), none negative, and constant of the least squares fit; exponents of 0 where frames are few."""
    if len(logs) < FRAMES_EACH * logs.shape[1]:
        return np.zeros(logs.shape[1]), float(targets.mean())
    ones = np.ones((len(logs), 1))
    found, _ = nnls(np.hstack([logs, ones, -ones]), targets)
    return found[:-2], float(found[-2] - found[-1])


@numba.njit(cache=True)
def indicate(parameters, modal, linear, middle):  # type: ignore[no-untyped-def]
    """Activity, interaction and tail of parameters (p,) with coordinates (r,), which are `linear` by superposition.

    middle: first coordinate of the upper half.
    """
    activity = 0.0
    for weight in parameters:
        activity += abs(weight) / (abs(weight) + HALF_ACTIVE)
    interaction, tail = 0.0, 0.0
    for k in range(len(modal)):
        interaction += (modal[k] - linear[k]) ** 2
        if k >= middle:
            tail += modal[k] ** 2
    return activity, interaction**0.5, tail**0.5
