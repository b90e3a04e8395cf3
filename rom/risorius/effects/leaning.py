"""How a head leans: poses in which weight is solved for, and the change of gravity as what each of them tells of."""

from __future__ import annotations

import numba
import numpy as np

from risorius.effects.effect import UPRIGHT
from risorius.jaw import FloatArray

LEANING = -UPRIGHT[1] * np.array(
    [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]
)
"""Gravity (5, 3), m/s2, of a head on its left and right side, upside down, on its face and on its back."""

HALVES = np.array([0, 0, 1, 2, 2])
"""Axis of each of the five half directions: both ways along x, y, both ways along z."""

BLEND = 1.0  # m/s2: of changes much smaller, both ways of an axis have a share


@numba.njit(cache=True, error_model="numpy")
def halves(gravity):  # type: ignore[no-untyped-def]
    """Change of gravity (3,) from upright in the half directions, (5,) m/s2: smooth, those of an axis add up to it.

    Upwards and downwards are not told apart: a head cannot weigh more than upright but where it is shaken.
    """
    result = np.empty(5)
    for axis, first in ((0, 0), (2, 3)):
        change = gravity[axis]
        share = 0.5 * (1.0 + change / np.sqrt(change * change + BLEND * BLEND))
        result[first], result[first + 1] = change * share, change * (1.0 - share)
    result[2] = gravity[1] - UPRIGHT[1]
    return result


def rest_responses(leaning: FloatArray) -> FloatArray:
    """Response (5, ...) per m/s2 in the half directions, from displacements (5, ...) in the poses of LEANING."""
    changes = np.array([halves(pose) for pose in LEANING])
    return np.asarray(np.tensordot(np.linalg.inv(changes), leaning, axes=1))
