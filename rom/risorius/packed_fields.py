"""Linear combinations of fields, as fast as memory is read and in one thread, whatever threads a BLAS has.

A BLAS that may use all cores does, for a product of this size: beside other work that costs milliseconds a frame.
"""

from __future__ import annotations

from typing import TypeVar

import numba
import numpy as np
import numpy.typing as npt

from risorius.jaw import FloatArray
from risorius.vector_sums import WIDTH, combine
from risorius.whole_steps import in_steps

Number = TypeVar("Number", np.float32, np.int16)


def whole_blocks(size: int) -> int:
    """Number of components that `combine` sums for a field of so many."""
    return -(-size // WIDTH) * WIDTH


def in_blocks(fields: npt.NDArray[Number]) -> npt.NDArray[Number]:
    """Fields (r, m) flat, as `combine` takes them: whole blocks, filled up with zeros."""
    count, size = fields.shape
    padded = np.zeros((count, whole_blocks(size)), fields.dtype)
    padded[:, :size] = fields
    return padded.reshape(count, -1, WIDTH).transpose(1, 0, 2).ravel()


class PackedFields:
    """Fields (r, m, 3) float32, block after block of components. Not thread-safe.

    Rounded ones (`whole_steps.rounded_fields`) are kept as 16-bit integers: half the bytes, and the same sums.

    largest: (r,) largest size of a component of each. itemsize: bytes of a component.
    """

    def __init__(self, fields: npt.NDArray[np.float32]) -> None:
        count, size = len(fields), fields[0].size
        flat = fields.reshape(count, size)
        self.largest = np.abs(flat).max(axis=1)
        numbers, steps = in_steps(flat.T)
        exact = np.array_equal(numbers.T * steps[:, None], flat)
        self._steps = steps if exact else np.ones(count, np.float32)
        self._blocks = in_blocks(numbers.T) if exact else in_blocks(flat)
        self._coordinates = np.empty(count, np.float32)
        self._sums = np.empty(whole_blocks(size), np.float32)
        self._size = size
        self.itemsize, self.nbytes = self._blocks.itemsize, self._blocks.nbytes

    def combined(self, coordinates: FloatArray) -> npt.NDArray[np.float32]:
        """Sum (3 m) of the fields times their coordinates (r,); the next call overwrites it."""
        _combine(self._blocks, coordinates, self._steps, self._coordinates, self._sums)
        return self._sums[: self._size]


@numba.njit(cache=True)
def _combine(fields, coordinates, steps, scaled, out):  # type: ignore[no-untyped-def]
    """Write the sums of fields times coordinates (r,) and steps (r,); scaled (r,) is working space."""
    for k in range(len(scaled)):
        scaled[k] = coordinates[k] * steps[k]
    combine(fields, scaled, out)
