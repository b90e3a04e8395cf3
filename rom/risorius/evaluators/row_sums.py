"""Sums of rows of a matrix, times what is given of each: the inner loop of the learned maps."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True, fastmath={"contract"})
def add_rows(factors, positions, count, matrix, out):  # type: ignore[no-untyped-def]
    """Add to out (r,) the sum, over k < count, of factors[k] times row positions[k] of a matrix (n, r).

    Matrix and `out` are single precision. Four rows at a time: `out` is read and written a quarter as often.
    """
    width = matrix.shape[1]
    whole = count - count % 4
    for k in range(0, whole, 4):
        a, b, c, d = (
            np.float32(factors[k]), np.float32(factors[k + 1]), np.float32(factors[k + 2]), np.float32(factors[k + 3])
        )  # fmt: skip
        i, j, m, n = positions[k], positions[k + 1], positions[k + 2], positions[k + 3]
        for r in range(width):
            out[r] += a * matrix[i, r] + b * matrix[j, r] + c * matrix[m, r] + d * matrix[n, r]
    for k in range(whole, count):
        a, i = np.float32(factors[k]), positions[k]
        for r in range(width):
            out[r] += a * matrix[i, r]
