"""Linear combinations of fields, as fast as memory is read and in one thread, whatever threads a BLAS has.

A BLAS that may use all cores does, for a product of this size: beside other work that costs milliseconds a frame.
"""

from __future__ import annotations

import numba
import numpy as np
import numpy.typing as npt

from risorius.jaw import FloatArray

BLOCK = 64  # components whose sums stay in the innermost cache
AT_ONCE = 8  # fields between two stores of a sum


class PackedFields:
    """Fields (r, m, 3) float32, block after block of components. Not thread-safe.

    largest: (r,) largest size of a component of each.
    """

    def __init__(self, fields: npt.NDArray[np.float32]) -> None:
        count, size = len(fields), fields[0].size
        padded = np.zeros((-(-count // AT_ONCE) * AT_ONCE, -(-size // BLOCK) * BLOCK), np.float32)
        padded[:count, :size] = fields.reshape(count, size)
        self.largest = np.abs(padded[:count]).max(axis=1)
        self._blocks = np.ascontiguousarray(padded.reshape(len(padded), -1, BLOCK).transpose(1, 0, 2))
        self._coordinates = np.zeros(len(padded), np.float32)
        self._sums = np.empty(padded.shape[1], np.float32)
        self._size = size
        self.nbytes = self._blocks.nbytes

    def combined(self, coordinates: FloatArray) -> npt.NDArray[np.float32]:
        """Sum (3 m) of the fields times their coordinates (r,); the next call overwrites it."""
        self._coordinates[: len(coordinates)] = coordinates
        _add_up(self._blocks, self._coordinates, self._sums)
        return self._sums[: self._size]


@numba.njit(cache=True, fastmath={"contract", "reassoc", "nsz"})
def _add_up(blocks, q, sums):  # type: ignore[no-untyped-def]
    for b in range(len(blocks)):
        fields, total = blocks[b], sums[b * BLOCK : (b + 1) * BLOCK]
        total[:] = 0.0
        for k in range(0, len(q), AT_ONCE):
            q0, q1, q2, q3, q4, q5, q6, q7 = q[k], q[k + 1], q[k + 2], q[k + 3], q[k + 4], q[k + 5], q[k + 6], q[k + 7]
            for i in range(BLOCK):
                total[i] += (
                    (q0 * fields[k, i] + q1 * fields[k + 1, i])
                    + (q2 * fields[k + 2, i] + q3 * fields[k + 3, i])
                    + (q4 * fields[k + 4, i] + q5 * fields[k + 5, i])
                    + (q6 * fields[k + 6, i] + q7 * fields[k + 7, i])
                )
