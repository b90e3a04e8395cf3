"""A rigid turn about an axis parallel to x (the person's left), as a combination of two fixed fields.

A point x turned by the angle theta about an axis through c moves by sin(theta) e_x x (x - c) minus 1 - cos(theta) times
the part of x - c across the axis: linear in the two *lift coordinates* sin(theta) and 1 - cos(theta). A positive angle
takes what lies in front of the axis (larger z) downwards.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

HINGE_COORDINATES = 2


def hinge_coordinates(angle: float) -> tuple[float, float]:
    """Return sin and 1 - cos of an angle in radians, the latter without cancellation."""
    return math.sin(angle), 2.0 * math.sin(0.5 * angle) ** 2


def hinge_slopes(angle: float) -> tuple[float, float]:
    """Return the derivatives of the hinge coordinates by the angle."""
    return math.cos(angle), math.sin(angle)


def hinge_motions(points: npt.ArrayLike, centre: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Displacement (2, n, 3) of points (n, 3) for each unit lift coordinate, about the axis through `centre` (3,)."""
    arm = np.asarray(points) - np.asarray(centre)
    fields = np.zeros((HINGE_COORDINATES, len(arm), 3))
    fields[0, :, 1], fields[0, :, 2] = -arm[:, 2], arm[:, 1]
    fields[1, :, 1], fields[1, :, 2] = -arm[:, 1], -arm[:, 2]
    return fields
