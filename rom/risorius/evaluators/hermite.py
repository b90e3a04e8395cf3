"""Ridge regression on values and derivatives, its ridge and the derivatives' weight chosen by cross-validation.

The normal equations are summed up snapshot by snapshot, one sum for each fold: memory does not grow with the number of
snapshots but by their values, and to leave a fold out is a subtraction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.linalg

from risorius.jaw import FloatArray

FOLDS = 5
RIDGES = 10.0 ** np.arange(-8.0, -3.0)  # times the number of snapshots
DERIVATIVE_WEIGHTS = (0.03, 0.1)


@dataclass(frozen=True)
class Choice:
    """Ridge, and weight of the derivatives beside the values."""

    ridge: float
    weight: float


class NormalEquations:
    """Rows of m features and r targets: those of values by fold, and sums of squares of those of derivatives."""

    def __init__(self, features: int, targets: int) -> None:
        self._features = features
        self._values: list[list[FloatArray]] = [[] for _ in range(FOLDS)]
        self._slopes = np.zeros((FOLDS, features, features + targets), np.float32)

    def add(self, fold: int, values: FloatArray, slopes: npt.NDArray[np.float32]) -> None:
        """Add rows (k, m + r), features first, of values and of derivatives to a fold."""
        self._values[fold].append(values)
        self._slopes[fold] += slopes[:, : self._features].T @ slopes

    def left_out_errors(self, choice: Choice) -> FloatArray:
        """Squared errors (s,) of each fold's snapshots, fold by fold, from a solution without that fold."""
        errors = []
        for fold in range(FOLDS):
            solution = self._solution([k for k in range(FOLDS) if k != fold], choice, np.arange(self._features))
            for rows in self._values[fold]:
                missed = rows[:, : self._features] @ solution - rows[:, self._features :]
                errors.append((missed**2).sum(axis=1))
        return np.concatenate(errors)

    def solution(self, choice: Choice, kept: npt.NDArray[np.int64]) -> FloatArray:
        """Coefficients (k, r) of some of the features (k,) from all snapshots."""
        return self._solution(range(FOLDS), choice, kept)

    def most_telling(self, choice: Choice, count: int) -> npt.NDArray[np.int64]:
        """The features (count,) that move the targets most: root mean square times size of the coefficients."""
        values = np.concatenate([rows for fold in self._values for rows in fold])[:, : self._features]
        squares = (values**2).sum(axis=0) + choice.weight**2 * np.einsum("fii->i", self._slopes[:, :, : self._features])
        size = np.linalg.norm(self.solution(choice, np.arange(self._features)), axis=1)
        return np.sort(np.argsort(-size * np.sqrt(squares), kind="stable")[:count])

    def _solution(self, folds: range | list[int], choice: Choice, kept: npt.NDArray[np.int64]) -> FloatArray:
        columns = np.concatenate([kept, np.arange(self._features, self._slopes.shape[2])])
        values = np.concatenate([rows for fold in folds for rows in self._values[fold]])[:, columns]
        count = len(kept)
        equations = values[:, :count].T @ values
        for fold in folds:
            equations += choice.weight**2 * self._slopes[fold][np.ix_(kept, columns)]
        matrix = equations[:, :count]
        matrix[np.diag_indices(count)] += choice.ridge * len(values)
        factor = scipy.linalg.cho_factor(matrix, check_finite=False)
        solution: FloatArray = scipy.linalg.cho_solve(factor, equations[:, count:], check_finite=False)
        return solution


def best_choice(systems: list[NormalEquations], weights: tuple[float, ...]) -> Choice:
    """Ridge and weight that serve independent systems over the same snapshots best together.

    That is, with the least sum of the errors (not of their squares: a few strong snapshots would decide) of snapshots
    that were left out. The weight is chosen at the middle ridge, the ridge then: each choice costs a factorisation.
    """

    def error(choice: Choice) -> float:
        return float(np.sqrt(np.sum([system.left_out_errors(choice) for system in systems], axis=0)).sum())

    middle = float(RIDGES[len(RIDGES) // 2])
    weight = min(weights, key=lambda weight: error(Choice(middle, weight)))
    return min((Choice(float(ridge), weight) for ridge in RIDGES), key=error)
