"""The sparse system of a Newton step over the free components, with one symbolic analysis for a mesh."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray
from risorius_offline.effects.effect import NodeBlocks
from risorius_offline.linear_solver import LinearSolver

# Added entries, as a multiple of those in use, from which the pattern is made anew.
LARGEST_SURPLUS = 4


class TangentSystem:
    """Factorises element tangents and node blocks, both given over all components, restricted to the free ones.

    pattern: upper triangle of the element tangents, rows <= columns. free (f,): numbers of the free components.
    rough: a solver for factors that need not be exact; the other one where there is none.
    Node blocks may couple nodes that share no element (contact): then the pattern grows and is analysed again. What it
    has grown by is kept, so that contacts that come and go cost no more analyses, until most of it is out of use.
    """

    def __init__(
        self, pattern: sp.csr_matrix, free: IntArray, solver: LinearSolver, rough: LinearSolver | None = None
    ) -> None:
        self._exact, self._rough = solver, rough or solver
        self._last = solver
        self._number = np.full(pattern.shape[0], -1, dtype=np.int64)
        self._number[free] = np.arange(len(free))
        rows = np.repeat(np.arange(pattern.shape[0]), np.diff(pattern.indptr))
        rows, columns = self._number[rows], self._number[pattern.indices]
        self._kept = np.flatnonzero((rows >= 0) & (columns >= 0))
        self._size = len(free)
        self._element_keys = self._keys(rows[self._kept], columns[self._kept])
        self._adopt(np.zeros(0, dtype=np.int64))

    def factorise(self, values: FloatArray, blocks: Sequence[NodeBlocks], *, rough: bool = False) -> None:
        """Factorise tangent values in the pattern plus node blocks; raises NotPositiveDefiniteError."""
        keys, entries = self._entries(blocks)
        positions = np.searchsorted(self._all_keys, keys)
        if len(keys) and not np.array_equal(self._all_keys[np.minimum(positions, len(self._all_keys) - 1)], keys):
            self._grow(np.unique(keys))
            positions = np.searchsorted(self._all_keys, keys)
        data = np.zeros(len(self._all_keys))
        data[self._element_positions] = values[self._kept]
        data += np.bincount(positions, weights=entries, minlength=len(data))
        self._last = self._rough if rough else self._exact
        if self._last not in self._analysed:
            self._last.analyse(self._pattern)
            self._analysed.append(self._last)
        self._last.factorise(data)

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Solution over the free components, (f,) or (f, k), with the last factors."""
        return self._last.solve(right_hand_side)

    def _grow(self, keys: IntArray) -> None:
        """Add the sorted keys of present blocks to the pattern, and leave out old ones if they are the most."""
        beyond = np.setdiff1d(keys, self._element_keys, assume_unique=True)
        grown = np.union1d(self._added_keys, beyond)
        self._adopt(grown if len(grown) <= LARGEST_SURPLUS * len(beyond) else beyond)

    def _adopt(self, added: IntArray) -> None:
        """Take the pattern of the elements with the sorted keys that are added to it; solvers have to analyse it."""
        self._added_keys = added
        keys = np.insert(self._element_keys, np.searchsorted(self._element_keys, added), added)
        self._all_keys = keys
        self._element_positions = np.searchsorted(keys, self._element_keys)
        rows, columns = np.divmod(keys, self._size)
        starts = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=self._size))])
        self._pattern = sp.csr_matrix((np.zeros(len(keys)), columns, starts), shape=(self._size, self._size))
        self._analysed: list[LinearSolver] = []

    def _entries(self, blocks: Sequence[NodeBlocks]) -> tuple[IntArray, FloatArray]:
        """Keys and values of the upper triangle over free components; entries of one key may repeat."""
        keys, entries = [np.zeros(0, dtype=np.int64)], [np.zeros(0)]
        for block in blocks:
            dofs = (3 * block.nodes[:, :, None] + np.arange(3)).reshape(len(block.nodes), block.matrices.shape[1])
            number = self._number[dofs]
            rows, columns = np.broadcast_arrays(number[:, :, None], number[:, None, :])
            upper = (rows >= 0) & (rows <= columns)
            keys.append(self._keys(rows[upper], columns[upper]))
            entries.append(block.matrices[upper])
        return np.concatenate(keys), np.concatenate(entries)

    def _keys(self, rows: IntArray, columns: IntArray) -> IntArray:
        return rows * self._size + columns
