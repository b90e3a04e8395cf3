"""Numbers of a table as integers of 16 or 8 bits: what is summed in every frame takes the time to read it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

Single = npt.NDArray[np.float32]
Kind = type[np.int16] | type[np.int8]


def in_steps(values: Single, kind: Kind = np.int16) -> tuple[npt.NDArray[Any], Single]:
    """Whole numbers (n, m) of steps (m,), powers of two, that are next to values; rounded ones are met exactly, also
    by some of their rows.
    """
    share, exponent = np.frexp(np.abs(values).max(axis=0, initial=0.0) / np.iinfo(kind).max)
    steps = np.ldexp(np.float32(1.0), np.where(share > 0.5, exponent, exponent - 1))
    return np.rint(values / steps).astype(kind), steps


def rounded_fields(fields: Single, kind: Kind = np.int16) -> Single:
    """Fields (r, c, 3) that are whole numbers of a step of their own: off by 1 / 32 767 of its largest at most, with
    eight bits by 1 / 127.
    """
    numbers, steps = in_steps(fields.reshape(len(fields), math.prod(fields.shape[1:])).T, kind)
    return np.ascontiguousarray((numbers * steps).T).reshape(fields.shape)
