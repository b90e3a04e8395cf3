"""A learned map: a sparse cubic polynomial in the parameters, fitted to snapshots by weighted ridge regression.

Features are the monomials p_i, p_i^2, p_i^3, p_i p_j and p_i^2 p_j. Two muscles interact only where both move tissue,
so a mixed monomial is scaled by the overlap of their displacement fields before the ridge: those of far muscles are
shrunk, and below a threshold left out. There is no constant: at rest the map is exact.
"""

from __future__ import annotations

from dataclasses import dataclass

import h5py
import numba
import numpy as np
import numpy.typing as npt

from risorius.evaluators.setting import Setting
from risorius.jaw import FloatArray
from risorius.part import Part

NEGLIGIBLE_OVERLAP = 0.02
RIDGES = 10.0 ** np.arange(-8.0, 1.0)
FOLDS = 5


@dataclass(frozen=True)
class PolynomialMap:
    """exponents: (m, 3) positions of the parameters whose product is the monomial, -1 for none.

    coefficients: (m, r), modal coordinates per unit monomial.
    """

    exponents: npt.NDArray[np.int32]
    coefficients: FloatArray
    name = "polynomial"
    doubt = 0.0

    def coordinates(self, parameters: FloatArray, out: FloatArray) -> None:
        """Write the modal coordinates (r,) of parameters (p,) into `out`."""
        _accumulate(parameters, self.exponents, self.coefficients, out)

    def at(self, setting: Setting) -> PolynomialMap:
        """Return that of the leading modes."""
        return PolynomialMap(self.exponents, np.ascontiguousarray(self.coefficients[:, : setting.rank]))

    def within(self, part: Part) -> PolynomialMap:
        """Return that of a part, without the monomials of parameters that it has not or that are always 0."""
        count = max(int(self.exponents.max()), int(part.parameters[-1])) + 1
        number = np.full(count + 1, -1, np.int32)  # the last is that of no parameter
        number[part.parameters] = np.arange(len(part.parameters))
        lost = np.ones(len(number), bool)
        lost[part.parameters[part.driven]] = lost[-1] = False
        kept = ~lost[self.exponents].any(axis=1)
        coefficients = self.coefficients[np.ix_(kept, part.modes)]
        return PolynomialMap(number[self.exponents[kept]], np.ascontiguousarray(coefficients))

    def write(self, group: h5py.Group) -> None:
        """Store monomials and coefficients."""
        group["exponents"] = self.exponents
        group["coefficients"] = self.coefficients

    @classmethod
    def read(cls, group: h5py.Group) -> PolynomialMap:
        """Load what `write` stored."""
        return cls(group["exponents"][()], group["coefficients"][()])

    @classmethod
    def fit(cls, parameters: FloatArray, coordinates: FloatArray, overlap: FloatArray) -> PolynomialMap:
        """Fit to snapshots: parameters (s, p), modal coordinates (s, r), overlap (p, p) in [0, 1].

        The ridge is chosen by cross-validation over the given snapshots.
        """
        exponents, scale = monomials(overlap)
        features = evaluate_monomials(parameters, exponents) * scale
        ridge = _best_ridge(features, coordinates)
        return cls(exponents, scale[:, None] * _ridge_solution(features, coordinates, [ridge])[0])


def monomials(overlap: FloatArray) -> tuple[npt.NDArray[np.int32], FloatArray]:
    """Monomials (m, 3) of interacting parameters and the scale (m,) of each, from the overlap (p, p)."""
    count = len(overlap)
    rows = [(i, -1, -1) for i in range(count)] + [(i, i, -1) for i in range(count)] + [(i, i, i) for i in range(count)]
    scale = [1.0] * len(rows)
    for i in range(count):
        for j in range(i + 1, count):
            if overlap[i, j] > NEGLIGIBLE_OVERLAP:
                rows += [(i, j, -1), (i, i, j), (i, j, j)]
                scale += [float(overlap[i, j])] * 3
    return np.array(rows, dtype=np.int32), np.array(scale)


def evaluate_monomials(parameters: FloatArray, exponents: npt.NDArray[np.int32]) -> FloatArray:
    """Values (s, m) of monomials (m, 3) at parameters (s, p)."""
    padded = np.column_stack([parameters, np.ones(len(parameters))])
    return padded[:, exponents].prod(axis=2)


def _best_ridge(features: FloatArray, targets: FloatArray) -> float:
    fold = np.arange(len(features)) % FOLDS
    error = np.zeros(len(RIDGES))
    for k in range(FOLDS):
        train, test = fold != k, fold == k
        for n, solution in enumerate(_ridge_solution(features[train], targets[train], RIDGES)):
            error[n] += ((features[test] @ solution - targets[test]) ** 2).sum()
    return float(RIDGES[error.argmin()])


def _ridge_solution(features: FloatArray, targets: FloatArray, ridges: npt.ArrayLike) -> list[FloatArray]:
    """Ridge solutions (m, r), one per relative ridge, from the smaller of the two matrices that give the same.

    That is F F' (s, s) when snapshots are few, F'F (m, m) when there are more of them than monomials.
    """
    few = len(features) <= features.shape[1]
    values, vectors = np.linalg.eigh(features @ features.T if few else features.T @ features)
    rotated = vectors.T @ (targets if few else features.T @ targets)
    largest = values[-1]
    found = [vectors @ (rotated / (values + ridge * largest)[:, None]) for ridge in np.asarray(ridges)]
    return [features.T @ weights for weights in found] if few else found


@numba.njit(cache=True)
def _accumulate(parameters, exponents, coefficients, out):  # type: ignore[no-untyped-def]
    out[:] = 0.0
    for m in range(exponents.shape[0]):
        value = 1.0
        for k in range(3):
            position = exponents[m, k]
            if position >= 0:
                value *= parameters[position]
        if value != 0.0:
            for r in range(out.shape[0]):
                out[r] += value * coefficients[m, r]
