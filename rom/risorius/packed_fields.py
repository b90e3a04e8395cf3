"""Linear combinations of fields, as fast as memory is read and in one thread, whatever threads a BLAS has.

A BLAS that may use all cores does, for a product of this size: beside other work that costs milliseconds a frame.
"""

from __future__ import annotations

from typing import TypeVar

import numba
import numpy as np
import numpy.typing as npt

from risorius import paired_sums, vector_sums
from risorius.jaw import FloatArray
from risorius.vector_sums import WIDTH, whole_blocks
from risorius.whole_steps import Single, in_steps

Number = TypeVar("Number", np.float32, np.int16)


def in_blocks(fields: npt.NDArray[Number]) -> npt.NDArray[Number]:
    """Fields (r, m) flat, as `combine` takes them: whole blocks, filled up with zeros."""
    count, size = fields.shape
    blocks = whole_blocks(size) // WIDTH
    padded = np.zeros((count, blocks * WIDTH), fields.dtype)
    padded[:, :size] = fields
    return padded.reshape(count, blocks, WIDTH).transpose(1, 0, 2).ravel()


class PackedFields:
    """Fields (r, m, 3) float32, block after block of components. Not thread-safe.

    Rounded ones (`whole_steps.rounded_fields`) are kept as 16-bit integers: half the bytes, and the same sums. Coarse
    ones (r,) are rounded to eight bits, and their coordinates to whole numbers up to LARGEST_INPUT, for all of them
    together.

    largest: (r,) largest size of a component of each. nbytes: of all.
    """

    def __init__(self, fields: Single, coarse: npt.NDArray[np.bool_] | None = None) -> None:
        count, size = len(fields), fields[0].size
        coarse = np.zeros(count, bool) if coarse is None else coarse
        flat = fields.reshape(count, size)
        self.largest = np.abs(flat).max(axis=1)
        self.coarse = coarse
        fine, fine_steps = _fine(flat[~coarse])
        numbers, steps = in_steps(flat[coarse].T, np.int8)
        self._fields = fine, paired_sums.in_pairs(numbers.T)
        self._order = np.concatenate([np.flatnonzero(~coarse), np.flatnonzero(coarse)])
        self._steps = np.concatenate([fine_steps, steps])
        self._coordinates = np.empty(count, np.float32)
        self._numbers = np.empty(len(numbers.T) + len(numbers.T) % 2, np.int16)
        self._whole_sums = np.empty(whole_blocks(size), np.int32)
        self._sums = np.empty(whole_blocks(size), np.float32)
        self._size = size
        self.nbytes = sum(part.nbytes for part in self._fields)

    def combined(self, coordinates: FloatArray) -> Single:
        """Sum (3 m) of the fields times their coordinates (r,); the next call overwrites it."""
        work = self._coordinates, self._numbers, self._whole_sums, self._sums
        _combine(*self._fields, coordinates, self._order, self._steps, *work)
        return self._sums[: self._size]

    def rounding(self, coordinates: FloatArray) -> float:
        """Metres that no component of the sum is further off by, since coordinates of coarse fields are rounded.

        Each by half a number, of at most 127 steps, which are less than twice the largest component.
        """
        sizes = np.abs(coordinates) * self.largest
        return float(self.coarse.sum() * sizes[self.coarse].max(initial=0.0)) / paired_sums.LARGEST_INPUT


def _fine(flat: Single) -> tuple[npt.NDArray[np.float32] | npt.NDArray[np.int16], Single]:
    """Fields (r, m) in blocks, as 16-bit integers where they are rounded, and their steps (r,)."""
    numbers, steps = in_steps(flat.T, np.int16)
    if np.array_equal(numbers.T * steps[:, None], flat):
        return in_blocks(numbers.T), steps
    return in_blocks(flat), np.ones(len(flat), np.float32)


@numba.njit(cache=True)
def _combine(  # type: ignore[no-untyped-def]
    fine, coarse, coordinates, order, steps, scaled, numbers, whole_sums, out
):
    """Write the sums of fields times coordinates (r,) and steps (r,); scaled, numbers and whole_sums are for work."""
    for k in range(len(order)):
        scaled[k] = coordinates[order[k]] * steps[k]
    split = len(fine) // len(out)
    vector_sums.combine(fine, scaled[:split], out)
    if split < len(scaled):
        step = paired_sums.in_numbers(scaled[split:], numbers)
        paired_sums.combine(coarse, numbers, whole_sums)
        for i in range(len(out)):
            out[i] += step * whole_sums[i]
