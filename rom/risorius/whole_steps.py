"""Numbers of a table as 16-bit integers: what is summed in every frame takes the time to read it."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

Single = npt.NDArray[np.float32]


def in_steps(values: Single) -> tuple[npt.NDArray[np.int16], Single]:
    """Whole numbers (n, m) of steps (m,), powers of two, that are next to values; rounded ones are met exactly, also
    by some of their rows.
    """
    share, exponent = np.frexp(np.abs(values).max(axis=0, initial=0.0) / np.iinfo(np.int16).max)
    steps = np.ldexp(np.float32(1.0), np.where(share > 0.5, exponent, exponent - 1))
    return np.rint(values / steps).astype(np.int16), steps


def rounded(values: Single) -> Single:
    """Values (n, m) that are whole numbers of the steps of their column."""
    numbers, steps = in_steps(values)
    return numbers * steps


def rounded_fields(fields: Single) -> Single:
    """Fields (r, c, 3) that are whole numbers of a step of their own: off by 1 / 32 767 of its largest at most."""
    flat = fields.reshape(len(fields), math.prod(fields.shape[1:]))
    return np.ascontiguousarray(rounded(flat.T).T).reshape(fields.shape)
