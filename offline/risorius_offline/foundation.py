"""What the first samples of a file tell of where later ones are, for Newton's method to start from.

Which samples are asked depends on a sample's place in the file only: so results depend neither on the number of workers
nor on interruptions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from risorius.jaw import FloatArray
from risorius.snapshot_file import SOLVED
from risorius.snapshot_store import SnapshotStore

# Single actions come first: with fewer of them there is nothing to interpolate between. More than the most cost memory.
FEWEST, MOST = 64, 512
# Samples before one that may still be in work while it starts.
IN_WORK = 16
# Of the covariance: length in the space of the parameters, weight of what is linear, and noise relative to its mean.
LENGTH, LINEAR, NOISE = 3.0, 0.1, 1e-4


def foundation(row: int) -> int:
    """How many of the first samples of a file are asked for one in a row: none, or a power of two.

    So a run comes only a few times to where these have to be finished, and few workers never wait for them.
    """
    finished = row - IN_WORK
    return 0 if finished < FEWEST else min(1 << (finished.bit_length() - 1), MOST)


@dataclass(frozen=True)
class Interpolation:
    """Displacements by parameters, by Gaussian-process regression (Rasmussen and Williams 2006) that is zero at rest.

    parameters (k, p), beside (k, 3 n): displacements less those with which tissue follows the bones, metres. weights
    (k, k): the inverse of their covariance.
    """

    parameters: FloatArray
    beside: npt.NDArray[np.float32]
    weights: FloatArray
    store: SnapshotStore

    @classmethod
    def of(cls, store: SnapshotStore, count: int) -> Interpolation | None:
        """Between those of the first `count` samples that were solved; None where there are none."""
        rows = np.flatnonzero(store.states[:count] == SOLVED)
        if not len(rows):
            return None
        parameters = store.parameters[rows]
        beside = [(store.displacement(row) - store.following(store.parameters[row])).ravel() for row in rows.tolist()]
        covariance = _covariance(parameters, parameters)
        noise = NOISE * np.trace(covariance) / len(rows)
        weights = np.linalg.inv(covariance + noise * np.eye(len(rows)))
        return cls(parameters, np.array(beside, np.float32), weights, store)

    def displacement(self, parameters: FloatArray) -> npt.NDArray[np.float32]:
        """Displacement (n, 3) to be expected at parameters (p,)."""
        weights = _covariance(parameters[None], self.parameters)[0] @ self.weights
        beside = weights.astype(np.float32) @ self.beside
        return (self.store.following(parameters) + beside.reshape(-1, 3)).astype(np.float32)


def _covariance(x: FloatArray, y: FloatArray) -> FloatArray:
    """Covariance (a, b) between parameters (a, p) and (b, p), zero with rest."""
    rest = np.zeros((1, x.shape[1]))
    return _bell(x, y) - _bell(x, rest) - _bell(rest, y) + 1.0 + LINEAR * x @ y.T


def _bell(x: FloatArray, y: FloatArray) -> FloatArray:
    squares = (x**2).sum(axis=1)[:, None] + (y**2).sum(axis=1) - 2.0 * x @ y.T
    return np.exp(-squares / (2.0 * LENGTH**2))
