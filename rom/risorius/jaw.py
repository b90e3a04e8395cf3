"""Motion of the mandible: a rotation about the axis through the condyles and a slide of the condyles.

A point x of the mandible moves by

    u(x) = (R(theta) - I) (x - c) + s e_z + d e_x,

with theta = w_open * opening_angle, s = w_open * opening_slide + w_forward * forward_slide and
d = w_sideways * sideways_slide. It is linear in the four numbers (sin theta, 1 - cos theta, s, d), the *lift
coordinates*: whatever extends the four unit motions into the tissue (the lift fields) moves the bone exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, TypeAlias

import numpy as np
import numpy.typing as npt

from risorius.hinge import hinge_coordinates, hinge_motions, hinge_slopes

FloatArray: TypeAlias = npt.NDArray[np.float64]


@dataclass(frozen=True)
class JawMotion:
    """Rigid motion of the mandible as a function of (jaw_open, jaw_forward, jaw_sideways).

    condyle_centre: (3,) a point of the hinge axis, metres; the axis is parallel to x (the person's left).
    opening_angle: radians at jaw_open = 1. opening_slide, forward_slide, sideways_slide: metres at weight 1.
    """

    condyle_centre: tuple[float, float, float]
    opening_angle: float
    opening_slide: float
    forward_slide: float
    sideways_slide: float

    inputs: ClassVar[tuple[str, ...]] = ("jaw_open", "jaw_forward", "jaw_sideways")
    lift_count: ClassVar[int] = 4

    def lift_coordinates(self, jaw: npt.ArrayLike, out: FloatArray | None = None) -> FloatArray:
        """Return the four lift coordinates (sin, 1 - cos, metres forward, metres sideways) of jaw weights (3,)."""
        opening, forward, sideways = np.asarray(jaw).tolist()
        result = np.empty(self.lift_count) if out is None else out
        result[0], result[1] = hinge_coordinates(opening * self.opening_angle)
        result[2] = opening * self.opening_slide + forward * self.forward_slide
        result[3] = sideways * self.sideways_slide
        return result

    def lift_slopes(self, jaw: npt.ArrayLike) -> FloatArray:
        """Return the derivatives (3, 4) of the lift coordinates by the jaw weights (3,)."""
        result = np.zeros((len(self.inputs), self.lift_count))
        result[0, :2] = self.opening_angle * np.array(hinge_slopes(float(np.asarray(jaw)[0]) * self.opening_angle))
        result[:2, 2] = self.opening_slide, self.forward_slide
        result[2, 3] = self.sideways_slide
        return result

    def unit_motions(self, points: FloatArray) -> FloatArray:
        """Displacement (4, n, 3) of rigidly moved points (n, 3) for each unit lift coordinate.

        Opening turns the chin downwards and backwards.
        """
        fields = np.zeros((self.lift_count, len(points), 3))
        fields[:2] = hinge_motions(points, self.condyle_centre)
        fields[2, :, 2] = 1.0
        fields[3, :, 0] = 1.0
        return fields
