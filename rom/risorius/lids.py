"""Motion of the upper eyelids: the tarsal plate of a lid turns about the centre of its eyeball.

The plate is stiff and slides on the eyeball, so that a point x of it moves by (R(theta) - I) (x - c), with
theta = w * closing_angle about an axis parallel to x. Levator palpebrae superioris, which lifts the lid, and its
relaxation act in the model as this pose, as the masticatory muscles act as the jaw's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from risorius.hinge import hinge_coordinates, hinge_motions, hinge_slopes
from risorius.jaw import FloatArray

Point = tuple[float, float, float]


@dataclass(frozen=True)
class LidMotion:
    """Rigid motion of both upper lids as a function of (upper_lid_L, upper_lid_R) in [-0.3, 1].

    centres: of the left and the right eyeball, metres. closing_angle: radians at weight 1, where the eye is closed; at
    -0.3 it is raised by three tenths of that.
    """

    centres: tuple[Point, Point]
    closing_angle: float

    inputs: ClassVar[tuple[str, ...]] = ("upper_lid_L", "upper_lid_R")
    lift_count: ClassVar[int] = 4

    def lift_coordinates(self, lids: npt.ArrayLike, out: FloatArray | None = None) -> FloatArray:
        """Return the four lift coordinates (sin, 1 - cos of the left lid, then of the right) of lid weights (2,)."""
        left, right = np.asarray(lids).tolist()
        result = np.empty(self.lift_count) if out is None else out
        result[0], result[1] = hinge_coordinates(left * self.closing_angle)
        result[2], result[3] = hinge_coordinates(right * self.closing_angle)
        return result

    def lift_slopes(self, lids: npt.ArrayLike) -> FloatArray:
        """Return the derivatives (2, 4) of the lift coordinates by the lid weights (2,)."""
        left, right = (float(weight) * self.closing_angle for weight in np.asarray(lids))
        result = np.zeros((len(self.inputs), self.lift_count))
        result[0, :2], result[1, 2:] = hinge_slopes(left), hinge_slopes(right)
        return self.closing_angle * result

    def unit_motions(self, points: FloatArray) -> FloatArray:
        """Displacement (4, n, 3) of points (n, 3) for each unit lift coordinate: as part of the left lid, then right.

        Closing takes the lid, which lies in front of the centre, downwards.
        """
        return np.concatenate([hinge_motions(points, centre) for centre in self.centres])
