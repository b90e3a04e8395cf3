"""How large many numbers are, in one pass that also finds those that are none."""

from __future__ import annotations

import numba
import numpy as np

_compiled = numba.njit(cache=True, error_model="numpy")


@_compiled
def length_squared(values):  # type: ignore[no-untyped-def]
    """Sum of squares: not finite where one of the values is not."""
    total = 0.0
    for value in values:
        total += value * value
    return total


@_compiled
def largest_size(values):  # type: ignore[no-untyped-def]
    """Largest size of single numbers (n,); not a number where one is not.

    Sizes are compared as integers, which order as they do, with those that are not finite above all: in vector lanes.
    """
    largest = np.uint32(0)
    bits = values.view(np.uint32)
    for k in range(len(bits)):
        largest = max(largest, bits[k] & np.uint32(0x7FFFFFFF))
    single = np.empty(1, np.uint32)
    single[0] = largest
    return single.view(np.float32)[0]
