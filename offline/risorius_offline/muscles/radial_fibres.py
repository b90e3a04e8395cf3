"""The seed's sphincter: an ellipse that contracts along its radial directions (Figure 7.10)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import h5py
import numpy as np

from risorius.errors import InputError
from risorius_offline.discretisation import Discretisation
from risorius_offline.muscles.ellipse import Ellipse
from risorius_offline.muscles.fibres import FibreField, InsertionEnd, volume_positions


@dataclass(frozen=True)
class RadialFibres:
    """Tissue within `radius` metres of the ellipse, pulled towards its centre, parallel to its plane."""

    ellipse: Ellipse
    radius: float
    kind: ClassVar[str] = "radial"

    def __post_init__(self) -> None:
        if self.radius >= min(self.ellipse.semi_axes):
            raise InputError(
                f"radial sphincter: its radius of {1e3 * self.radius:g} mm reaches its centre (semi-axes "
                f"{' and '.join(f'{1e3 * axis:g}' for axis in self.ellipse.semi_axes)} mm); give a smaller radius"
            )

    def field(self, discretisation: Discretisation) -> FibreField:
        """Points within the radius; raises InputError where there are none."""
        positions = volume_positions(discretisation)
        inside, _ = self.ellipse.tube(positions, self.radius)
        inwards = np.array(self.ellipse.centre) - positions[inside]
        plane = self.ellipse.axes[:2]
        inwards = inwards @ plane.T @ plane
        return FibreField(inside, inwards / np.linalg.norm(inwards, axis=1, keepdims=True))

    def length(self, discretisation: Discretisation) -> float:
        """Mean length of the radial lines in the tube, pi/2 times its radius, metres."""
        return 0.5 * math.pi * self.radius

    def insertion_end(self, discretisation: Discretisation) -> InsertionEnd:
        """Raises InputError: a sphincter has none."""
        raise InputError("a radial sphincter has no insertion; leave the insertion cone out")

    def write(self, group: h5py.Group) -> None:
        """Store ellipse and radius."""
        self.ellipse.write(group)
        group.attrs["radius"] = self.radius

    @classmethod
    def read(cls, group: h5py.Group) -> RadialFibres:
        """Load what `write` stored."""
        return cls(Ellipse.read(group), float(group.attrs["radius"]))
