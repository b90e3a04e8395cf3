"""The insertion area of a muscle, a cone-shaped prolongation in which its fibres branch out (7.4, Figure 7.6).

The seed gives two numbers, the effective radius of action R and the apex angle alpha (Table 7.3), and neither a length
nor the place of the apex. Here R is the radius of the cone's base and alpha the full angle at its apex; the cone
prolongs the muscle, so it starts at the muscle's end with the radius r of the muscle's section there. Nothing else has
to be made up: the apex lies r / tan(alpha / 2) behind the end on the muscle's axis, the base (R - r) / tan(alpha / 2)
before it (R = 8 mm, alpha = 30 degrees, r = 4 mm: 15 mm). Force acts in what tissue the cone contains.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from risorius.errors import InputError
from risorius_offline.discretisation import Discretisation
from risorius_offline.muscles.fibres import FibreField, InsertionEnd, volume_positions


@dataclass(frozen=True)
class InsertionCone:
    """radius: R in metres. apex_angle: alpha in radians, the full opening angle."""

    radius: float
    apex_angle: float

    def __post_init__(self) -> None:
        if not (self.radius > 0.0 and 0.0 < self.apex_angle < math.pi):
            raise InputError(
                f"insertion cone: radius {self.radius:g} m, apex angle {math.degrees(self.apex_angle):g} degrees; "
                "give a positive radius and an angle between 0 and 180 degrees"
            )

    def field(self, discretisation: Discretisation, end: InsertionEnd) -> FibreField:
        """Points in the cone that prolongs `end`, each pulled towards the apex.

        Raises InputError for a muscle's end as wide as the cone, and for a cone without tissue.
        """
        if end.radius >= self.radius:
            raise InputError(
                f"the muscle ends with a radius of {1e3 * end.radius:.3g} mm, its insertion cone with "
                f"{1e3 * self.radius:.3g} mm; give a wider cone or a thinner muscle"
            )
        slope = math.tan(0.5 * self.apex_angle)
        apex = end.point - end.direction * end.radius / slope
        from_apex = volume_positions(discretisation) - apex
        height = from_apex @ end.direction
        across = np.linalg.norm(from_apex - height[:, None] * end.direction, axis=1)
        inside = np.flatnonzero(
            (height >= end.radius / slope) & (height <= self.radius / slope) & (across <= height * slope)
        )
        if not len(inside):
            raise InputError("no tissue in its insertion cone; check where its fibres end, or give a wider cone")
        towards = -from_apex[inside]
        return FibreField(inside, towards / np.linalg.norm(towards, axis=1, keepdims=True))


def _cone(centimetres: float, degrees: float) -> InsertionCone:
    return InsertionCone(1e-2 * centimetres, math.radians(degrees))


# Table 7.3, by the names of `risorius.facs`; the seed calls depressor anguli oris and levator anguli oris "angularis
# oris", depressor labii inferioris and levator labii superioris by their first two words. The seed's first study took
# 0.6 cm and 28 degrees for zygomaticus major.
TABLE_7_3: Mapping[str, InsertionCone] = MappingProxyType(
    {
        "zygomaticus_major": _cone(0.8, 30.0),
        "zygomaticus_minor": _cone(0.5, 30.0),
        "risorius": _cone(0.5, 25.0),
        "depressor_anguli_oris": _cone(0.7, 28.0),
        "levator_anguli_oris": _cone(0.7, 30.0),
        "depressor_labii_inferioris": _cone(0.4, 30.0),
        "levator_labii_superioris": _cone(0.4, 30.0),
    }
)
