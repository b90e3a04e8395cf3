"""What stops tissue that is pressed: springs that push and never pull, with play before they touch."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import h5py
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from risorius import storage
from risorius.jaw import FloatArray


@dataclass(frozen=True)
class OneSidedSprings:
    """Spring j pushes with strength_j o^2, newtons, where o = max(0, -play_j - rows_j u) is its overlap.

    rows (k, 3 n), sparse: how a displacement u of n nodes opens each gap. play (k,) metres, at least 0: tissue at rest
    is free of them. strength (k,) N/m2. It is the pressure law of contact in the full model.
    """

    rows: sp.csr_matrix
    play: FloatArray
    strength: FloatArray

    @classmethod
    def between(
        cls, nodes: npt.NDArray[np.integer], gradients: FloatArray, count: int, play: FloatArray, strength: FloatArray
    ) -> OneSidedSprings:
        """Springs whose gaps change with some of `count` nodes each, nodes (k, a), by gradients (k, a, 3)."""
        columns = 3 * nodes[:, :, None] + np.arange(3)
        starts = 3 * nodes.shape[1] * np.arange(len(nodes) + 1)
        rows = sp.csr_matrix((gradients.ravel(), columns.ravel(), starts), shape=(len(nodes), 3 * count))
        return cls(rows, play, strength)

    @classmethod
    def joined(cls, parts: list[OneSidedSprings]) -> OneSidedSprings:
        """All springs of parts, one at least, on the same nodes."""
        return cls(
            sp.csr_matrix(sp.vstack([part.rows for part in parts])),
            np.concatenate([part.play for part in parts]),
            np.concatenate([part.strength for part in parts]),
        )

    @classmethod
    def none(cls, size: int) -> OneSidedSprings:
        """No springs on `size` components of a displacement."""
        return cls(sp.csr_matrix((0, size)), np.zeros(0), np.zeros(0))

    def on(self, components: npt.NDArray[np.integer]) -> OneSidedSprings:
        """The springs where only some components of the displacement are not 0, and are all that is given."""
        return OneSidedSprings(sp.csr_matrix(self.rows[:, components]), self.play, self.strength)

    def mean_stiffness(self, displacements: Iterable[FloatArray]) -> sp.csr_matrix:
        """Mean second derivatives (3 n, 3 n), N/m, of the energy at displacements (n, 3) each, one at least."""
        slopes = [2.0 * self.strength * np.maximum(0.0, -self.play - self.rows @ u.ravel()) for u in displacements]
        return sp.csr_matrix(self.rows.T @ sp.diags_array(np.mean(slopes, axis=0)) @ self.rows)

    def write(self, group: h5py.Group) -> None:
        """Store all fields."""
        storage.write_sparse(group.create_group("rows"), self.rows)
        group["play"], group["strength"] = self.play, self.strength

    @classmethod
    def read(cls, group: h5py.Group) -> OneSidedSprings:
        """Load what `write` stored."""
        return cls(storage.read_sparse(group["rows"]), group["play"][()], group["strength"][()])
