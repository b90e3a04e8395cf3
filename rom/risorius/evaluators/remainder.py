"""What a learned map misses at usual inputs, interpolated: single actions, their ramps and named expressions.

A regularised Gaussian interpolant in the parameters (kernel ridge regression; Saunders, Gammerman and Vovk 1998) with a
width so small that combinations of several actions hardly feel it: all but a tenth of what is missed at its centres
goes, and the map is left as it is elsewhere. Its kernel is that of what is known to be 0 at rest, k(p, c) - k(p, 0)
k(0, c), so that another centre lies there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import h5py
import numba
import numpy as np
import numpy.typing as npt

from risorius.evaluators.observations import Observations
from risorius.jaw import FloatArray

WIDTH = 0.35  # of exp(-d^2 / 2), in units of the parameters
RIDGE = 0.01
FARTHEST = 18.0  # squared distance in widths, where a ten thousandth is left of what a centre adds
ROUNDING = 9  # decimals of parameters that are the same


@dataclass(frozen=True)
class Remainder:
    """centres (c, p) in widths, squares (c,) of their distances from rest, also in parameters that are left out;
    weights (c, r), what each adds to modal coordinates where it is. Not thread-safe.
    """

    centres: FloatArray
    squares: FloatArray
    weights: npt.NDArray[np.float32]

    @classmethod
    def fit(cls, observations: Observations, missed: FloatArray) -> Remainder:
        """Interpolate what a map misses (s, r) at the observations; at rest it misses nothing."""
        parameters, targets = observations.parameters, missed
        mirror = observations.reflection
        if mirror is not None:
            parameters = np.vstack([parameters, parameters[:, mirror.partner] * mirror.sign])
            targets = np.vstack([targets, targets * mirror.parity])
        centres, places = np.unique(np.round(parameters, ROUNDING) + 0.0, axis=0, return_inverse=True)
        means = np.zeros((len(centres), targets.shape[1]))
        np.add.at(means, places.ravel(), targets)
        means /= np.bincount(places.ravel(), minlength=len(centres))[:, None]
        centres = centres / WIDTH
        squares = np.square(centres).sum(axis=1)
        at_rest = np.where(squares < FARTHEST, np.exp(-0.5 * squares), 0.0)
        kernel = np.exp(-0.5 * np.maximum(squares[:, None] + squares - 2.0 * centres @ centres.T, 0.0))
        kernel += RIDGE * np.eye(len(centres)) - np.outer(at_rest, at_rest)
        weights = np.linalg.solve(kernel, means)
        weights = np.vstack([-at_rest @ weights, weights])
        rest = np.zeros((1, centres.shape[1]))
        return cls(np.vstack([rest, centres]), np.concatenate([[0.0], squares]), weights.astype(np.float32))

    def add(self, parameters: FloatArray, out: FloatArray) -> None:
        """Add the interpolant at parameters (p,) to modal coordinates (r,)."""
        _add(parameters, *self._tables, self.weights, self._away, out)

    @cached_property
    def _tables(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
        return np.ascontiguousarray(self.centres.T, np.float32), self.squares.astype(np.float32)

    @cached_property
    def _away(self) -> npt.NDArray[np.float32]:
        return np.empty(len(self.centres), np.float32)

    def only(self, modes: npt.NDArray[np.int64], parameters: npt.NDArray[np.int64]) -> Remainder:
        """Return that of some modes, for some of the parameters; the others are 0."""
        centres = self.centres[:, parameters]
        near = self.squares - np.square(centres).sum(axis=1) < FARTHEST
        return Remainder(centres[near], self.squares[near], np.ascontiguousarray(self.weights[near][:, modes]))

    def write(self, group: h5py.Group) -> None:
        """Store all fields."""
        group["centres"], group["squares"], group["weights"] = self.centres, self.squares, self.weights

    @classmethod
    def read(cls, group: h5py.Group) -> Remainder:
        """Load what `write` stored."""
        return cls(*(group[name][()] for name in ("centres", "squares", "weights")))


@numba.njit(cache=True, fastmath={"contract", "reassoc"})
def _add(parameters, across, squares, weights, away, out):  # type: ignore[no-untyped-def]
    """Only parameters that are not 0 take time: |p - c|^2 = |c|^2 + sum of p_i^2 - 2 p_i c_i."""
    if not parameters.any():
        return  # exactly 0
    away[:] = squares
    for i in range(len(parameters)):
        own = np.float32(parameters[i] / WIDTH)
        if own != 0.0:
            for k in range(len(away)):
                away[k] += own * (own - np.float32(2.0) * across[i, k])
    for k in range(len(away)):
        if away[k] < FARTHEST:
            share = np.exp(np.float32(-0.5) * away[k])
            for r in range(len(out)):
                out[r] += share * weights[k, r]
