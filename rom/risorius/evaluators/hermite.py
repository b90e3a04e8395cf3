"""Ridge regression on values and derivatives, its ridge and the derivatives' weight chosen by cross-validation.

The normal equations are summed up snapshot by snapshot, one sum for each fold: memory does not grow with the number of
snapshots, and to leave a fold out is a subtraction.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from risorius.jaw import FloatArray

FOLDS = 5
BATCH = 16
RIDGES = 10.0 ** np.arange(-8.0, -2.0)  # times the number of snapshots
DERIVATIVE_WEIGHTS = (0.03, 0.1, 0.3)


@dataclass(frozen=True)
class Rows:
    """One snapshot: features (1 or 1 + p, m), the value's first and then those of the derivatives; targets alike."""

    features: FloatArray
    targets: FloatArray


class NormalEquations:
    """Sums over the snapshots of each fold: of values, and of derivatives with weight 1."""

    def __init__(self, features: int, targets: int) -> None:
        self._value = np.zeros((FOLDS, features, features + targets))
        self._slope = np.zeros((FOLDS, features, features + targets))
        self._values: list[list[FloatArray]] = [[] for _ in range(FOLDS)]
        self._features = features
        self.count = 0
        self.slopes = 0

    def add(self, fold: int, batch: Iterable[Rows]) -> None:
        """Add snapshots to a fold."""
        rows = list(batch)
        values = np.stack([np.concatenate([row.features[0], row.targets[0]]) for row in rows])
        slopes = np.concatenate([np.hstack([row.features[1:], row.targets[1:]]) for row in rows]).astype(np.float32)
        self._value[fold] += values[:, : self._features].T @ values
        self._slope[fold] += slopes[:, : self._features].T @ slopes
        self._values[fold].append(values)
        self.count += len(rows)
        self.slopes += len(slopes)

    def left_out_errors(self, ridge: float, weight: float) -> FloatArray:
        """Squared errors (s,) of each fold's snapshots, fold by fold, from a solution without that fold."""
        value, slope = self._value.sum(axis=0), self._slope.sum(axis=0)
        errors = []
        for fold in range(FOLDS):
            seen = value - self._value[fold] + weight**2 * (slope - self._slope[fold])
            left = np.concatenate(self._values[fold]) if self._values[fold] else np.zeros((0, seen.shape[1]))
            solution = self._solution(seen, ridge)
            errors.append(((left[:, : self._features] @ solution - left[:, self._features :]) ** 2).sum(axis=1))
        return np.concatenate(errors)

    def solution(self, ridge: float, weight: float) -> FloatArray:
        """Coefficients (m, r) from all snapshots."""
        return self._solution(self._value.sum(axis=0) + weight**2 * self._slope.sum(axis=0), ridge)

    def _solution(self, equations: FloatArray, ridge: float) -> FloatArray:
        matrix = equations[:, : self._features].copy()
        matrix[np.diag_indices(self._features)] += ridge * self.count
        factor = scipy.linalg.cho_factor(matrix, overwrite_a=True, check_finite=False)
        solution: FloatArray = scipy.linalg.cho_solve(factor, equations[:, self._features :], check_finite=False)
        return solution


def best_solutions(systems: list[NormalEquations]) -> list[FloatArray]:
    """Coefficients of independent systems over the same snapshots, with the ridge and weight that serve best together.

    That is, with the least sum of the errors (not of their squares: a few strong snapshots would decide) of snapshots
    that were left out.
    """
    weights = DERIVATIVE_WEIGHTS if systems[0].slopes else (0.0,)
    choices = [(ridge, weight) for ridge in RIDGES for weight in weights]
    scores = [
        np.sqrt(np.sum([system.left_out_errors(*choice) for system in systems], axis=0)).sum() for choice in choices
    ]
    best = choices[int(np.argmin(scores))]
    return [system.solution(*best) for system in systems]
