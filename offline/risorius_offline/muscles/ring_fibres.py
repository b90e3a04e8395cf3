"""A sphincter as a ring of fibres: tissue around an ellipse contracts along the ellipse and so narrows it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import h5py
import numpy as np

from risorius.errors import InputError
from risorius_offline.discretisation import Discretisation
from risorius_offline.muscles.ellipse import Ellipse
from risorius_offline.muscles.fibres import FibreField, InsertionEnd, volume_positions


@dataclass(frozen=True)
class RingFibres:
    """Tissue within `radius` metres of the ellipse, along the tangent of the ellipse at its closest point.

    The ring has neither origin nor insertion: it takes an active stress, not a force density.
    """

    ellipse: Ellipse
    radius: float
    kind: ClassVar[str] = "ring"

    def field(self, discretisation: Discretisation) -> FibreField:
        """Points within the radius; raises InputError where there are none."""
        inside, angle = self.ellipse.tube(volume_positions(discretisation), self.radius)
        tangent = self.ellipse.curve(angle)[1]
        return FibreField(inside, tangent / np.linalg.norm(tangent, axis=1, keepdims=True))

    def length(self, discretisation: Discretisation) -> float:
        """Circumference of the ellipse, metres."""
        return self.ellipse.circumference

    def insertion_end(self, discretisation: Discretisation) -> InsertionEnd:
        """Raises InputError: a ring has none."""
        raise InputError("a ring of fibres has no insertion; leave the insertion cone out")

    def write(self, group: h5py.Group) -> None:
        """Store ellipse and radius."""
        self.ellipse.write(group)
        group.attrs["radius"] = self.radius

    @classmethod
    def read(cls, group: h5py.Group) -> RingFibres:
        """Load what `write` stored."""
        return cls(Ellipse.read(group), float(group.attrs["radius"]))
