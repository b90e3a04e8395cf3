"""An ellipse in space, the shape of a sphincter, and the tissue around it."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property

import h5py
import numpy as np
from scipy.special import ellipe

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray
from risorius_offline.muscles.closest_point import closest_parameters
from risorius_offline.muscles.polyline_fibres import no_tissue

SAMPLES = 128


@dataclass(frozen=True)
class Ellipse:
    """centre (3,) in metres; normal (3,) of its plane; first_axis (3,), what of it lies in the plane is the direction
    of the first of the two semi_axes (metres).
    """

    centre: tuple[float, float, float]
    normal: tuple[float, float, float]
    first_axis: tuple[float, float, float]
    semi_axes: tuple[float, float]

    def __post_init__(self) -> None:
        if np.linalg.norm(np.cross(self.normal, self.first_axis)) == 0.0:
            raise InputError(
                f"ellipse: normal {self.normal} and first axis {self.first_axis} are parallel or zero; "
                "give a first axis in the plane of the ellipse"
            )

    @cached_property
    def axes(self) -> FloatArray:
        """(3, 3) rows: first axis, second axis, normal; orthonormal and right-handed."""
        normal = np.array(self.normal) / np.linalg.norm(self.normal)
        first = np.array(self.first_axis) - normal * (normal @ np.array(self.first_axis))
        first /= np.linalg.norm(first)
        return np.array([first, np.cross(normal, first), normal])

    @property
    def circumference(self) -> float:
        """Metres: 4 a E(1 - b^2 / a^2), the complete elliptic integral of the second kind."""
        short, long = sorted(self.semi_axes)
        return 4.0 * long * float(ellipe(1.0 - (short / long) ** 2))

    def curve(self, angle: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Position, first and second derivative (k, 3) at eccentric angles (k,)."""
        scaled = np.array(self.semi_axes)[:, None] * self.axes[:2]
        radius = np.column_stack([np.cos(angle), np.sin(angle)]) @ scaled
        return np.array(self.centre) + radius, np.column_stack([-np.sin(angle), np.cos(angle)]) @ scaled, -radius

    def tube(self, positions: FloatArray, radius: float) -> tuple[IntArray, FloatArray]:
        """Numbers (k,) of the positions (n, 3) within `radius` metres of the ellipse, and the closest angles (k,).

        Raises InputError where there are none.
        """
        samples = np.linspace(0.0, 2.0 * np.pi, SAMPLES)
        near, angle = closest_parameters(positions, self.curve, samples, (-np.inf, np.inf), radius)
        inside = np.linalg.norm(self.curve(angle)[0] - positions[near], axis=1) <= radius
        if not inside.any():
            raise InputError(no_tissue(radius))
        return near[inside], angle[inside]

    def write(self, group: h5py.Group) -> None:
        """Store the ellipse as attributes."""
        group.attrs.update(asdict(self))

    @classmethod
    def read(cls, group: h5py.Group) -> Ellipse:
        """Load what `write` stored."""
        return cls(*(tuple(group.attrs[key].tolist()) for key in ("centre", "normal", "first_axis", "semi_axes")))
