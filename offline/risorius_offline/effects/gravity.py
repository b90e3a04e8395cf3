"""Weight of the tissue when the head leaves the pose in which its shape was taken."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from risorius.mechanics.material import TISSUE_DENSITY
from risorius_offline.discretisation import Discretisation
from risorius_offline.effects.dead_load import DeadLoad

# Upright: y is up in every anatomy.
UPRIGHT = (0.0, -9.81, 0.0)


def gravity(discretisation: Discretisation, acceleration: npt.ArrayLike, taken_under: npt.ArrayLike) -> DeadLoad:
    """Consistent nodal load, density times the change of acceleration (3,) in m/s2 from that of the shape at rest.

    The shape of a living face already carries its weight: taken upright, it does not sag when it is upright. Give
    `taken_under` = (0, 0, 0) for a shape without weight.
    """
    change = np.asarray(acceleration, dtype=np.float64) - np.asarray(taken_under, dtype=np.float64)
    return DeadLoad(TISSUE_DENSITY * discretisation.consistent_volumes[:, None] * change)
