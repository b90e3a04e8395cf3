"""Fibres along B-splines through given points: smooth lines of action from a few points (after 7.5 of the seed)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import h5py
import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.discretisation import Discretisation
from risorius_offline.muscles.closest_point import Curve, closest_parameters
from risorius_offline.muscles.fibres import FibreField, InsertionEnd, volume_positions
from risorius_offline.muscles.polyline_fibres import mean_end, mean_length, no_tissue

DEGREE = 3
SAMPLES_PER_SPAN = 16
CHORDS = 1000  # of a spline, when its length is measured


@dataclass(frozen=True)
class SplineFibres:
    """Tissue within a radius of a cubic B-spline, along the spline's derivative at the closest point.

    lines: points (k, 3) each, metres, from the origin to the insertion. The spline passes through all of them; its
    knots are clamped, so that it starts and ends there. Its parameter is the length of the chords, normalised to
    [0, 1], which makes interpolation of the fourth order (Floater and Surazhsky 2006), tangents of the third. With
    three or two points it is a parabola or a straight line.
    origin_radius, insertion_radius: metres; the radius goes linearly from one to the other along the parameter.
    """

    lines: tuple[FloatArray, ...]
    origin_radius: float
    insertion_radius: float
    kind: ClassVar[str] = "splines"

    def __post_init__(self) -> None:
        for number, line in enumerate(self.lines):
            if (np.linalg.norm(np.diff(line, axis=0), axis=1) == 0.0).any():
                raise InputError(f"line {number} has the same point twice in a row; leave one of them out")

    @property
    def radius(self) -> float:
        """The larger of the two radii, metres."""
        return max(self.origin_radius, self.insertion_radius)

    @cached_property
    def splines(self) -> tuple[BSpline, ...]:
        """Each line as a function from [0, 1] to (..., 3) metres."""
        return tuple(_spline_through(line) for line in self.lines)

    def field(self, discretisation: Discretisation) -> FibreField:
        """Points within the radius; raises InputError where there are none."""
        positions = volume_positions(discretisation)
        best = np.full(len(positions), np.inf)
        tangent = np.zeros_like(positions)
        for spline in self.splines:
            samples = np.linspace(0.0, 1.0, SAMPLES_PER_SPAN * len(spline.c) + 1)
            near, t = closest_parameters(positions, _curve(spline), samples, (0.0, 1.0), self.radius)
            distance = np.linalg.norm(spline(t) - positions[near], axis=1)
            radius = self.origin_radius + (self.insertion_radius - self.origin_radius) * t
            closer = (distance <= radius) & (distance < best[near])
            best[near[closer]] = distance[closer]
            tangent[near[closer]] = spline(t[closer], 1)
        inside = np.flatnonzero(np.isfinite(best))
        if not len(inside):
            raise InputError(no_tissue(self.radius))
        directions = -tangent[inside] / np.linalg.norm(tangent[inside], axis=1, keepdims=True)
        return FibreField(inside, directions)

    def length(self, discretisation: Discretisation) -> float:
        """Mean length of the splines, metres, along fine chords."""
        return mean_length(spline(np.linspace(0.0, 1.0, CHORDS + 1)) for spline in self.splines)

    def insertion_end(self, discretisation: Discretisation) -> InsertionEnd:
        """Mean of the ends and of the end tangents of the lines."""
        ends, tangents = (np.array([spline(1.0, order) for spline in self.splines]) for order in (0, 1))
        return mean_end(ends, tangents, self.insertion_radius)

    def write(self, group: h5py.Group) -> None:
        """Store points and radii."""
        group.attrs.update(origin_radius=self.origin_radius, insertion_radius=self.insertion_radius)
        for number, line in enumerate(self.lines):
            group[f"{number:03d}"] = line

    @classmethod
    def read(cls, group: h5py.Group) -> SplineFibres:
        """Load what `write` stored."""
        radii = (float(group.attrs[key]) for key in ("origin_radius", "insertion_radius"))
        return cls(tuple(line[()] for line in group.values()), *radii)


def _spline_through(line: FloatArray) -> BSpline:
    chords = np.concatenate([[0.0], np.linalg.norm(np.diff(line, axis=0), axis=1).cumsum()])
    return make_interp_spline(chords / chords[-1], line, k=min(DEGREE, len(line) - 1))


def _curve(spline: BSpline) -> Curve:
    return lambda t: (spline(t), spline(t, 1), spline(t, 2))
