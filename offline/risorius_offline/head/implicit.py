"""Shapes as implicit functions, negative inside, and sculptures blended from them.

Values are distances near the surface; far from it they only have the right sign. Lengths are in millimetres here, as
in the tables of `skin.py` and `skull.py`; `head.py` turns them into metres. Sums over coordinates are written out: the
result at a point then never depends on the others, and mirror images are exact; it is also faster than by rows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from risorius.jaw import FloatArray

Triple = tuple[float, float, float]

CURVE_PIECES = 24


class Shape(Protocol):
    """A solid given by an implicit function."""

    def distance(self, points: FloatArray) -> FloatArray:
        """Values (n,) at points (n, 3): negative inside."""
        ...


@dataclass(frozen=True)
class Ellipsoid:
    """Ellipsoid; yaw turns it about y, degrees. Distance to first order (Quilez 2008)."""

    centre: Triple
    radii: Triple
    yaw: float = 0.0

    def distance(self, points: FloatArray) -> FloatArray:
        """Values (n,) at points (n, 3)."""
        x, y, z = np.ascontiguousarray((points - np.asarray(self.centre)).T)
        c, s = math.cos(math.radians(self.yaw)), math.sin(math.radians(self.yaw))
        a, b, d = (c * x - s * z) / self.radii[0], y / self.radii[1], (s * x + c * z) / self.radii[2]
        scaled = np.sqrt(a * a + b * b + d * d)
        steepness = np.sqrt((a / self.radii[0]) ** 2 + (b / self.radii[1]) ** 2 + (d / self.radii[2]) ** 2)
        result: FloatArray = scaled * (scaled - 1.0) / np.maximum(steepness, 1e-9)
        return result


@dataclass(frozen=True)
class Sweep:
    """A ball of varying radius swept along a smooth curve through points."""

    points: tuple[Triple, ...]
    radii: tuple[float, ...]

    def distance(self, points: FloatArray) -> FloatArray:
        """Values (n,) at points (n, 3)."""
        curve, radii = self._curve
        result = np.full(len(points), np.inf)
        x, y, z = np.ascontiguousarray(points.T)
        for a, b, start, end in zip(curve[:-1], curve[1:], radii[:-1], radii[1:], strict=True):
            ex, ey, ez = b - a
            dx, dy, dz = x - a[0], y - a[1], z - a[2]
            along = np.clip((dx * ex + dy * ey + dz * ez) / (ex * ex + ey * ey + ez * ez), 0.0, 1.0)
            away = np.sqrt((dx - along * ex) ** 2 + (dy - along * ey) ** 2 + (dz - along * ez) ** 2)
            result = np.minimum(result, away - (start + (end - start) * along))
        return result

    @cached_property
    def _curve(self) -> tuple[FloatArray, FloatArray]:
        given = np.array(self.points)
        if len(given) == 2:
            return given, np.array(self.radii)
        at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(given, axis=0), axis=1))])
        fine = np.linspace(0.0, at[-1], CURVE_PIECES + 1)
        return CubicSpline(at, given)(fine), PchipInterpolator(at, self.radii)(fine)


@dataclass(frozen=True)
class Stroke:
    """One step of a sculpture: a shape added to what is there, or carved from it, with a blend of some millimetres."""

    shape: Shape
    blend: float
    carve: bool = False


def add(shape: Shape, blend: float) -> Stroke:
    """Add a shape with a fillet of about `blend` millimetres."""
    return Stroke(shape, blend)


def carve(shape: Shape, blend: float) -> Stroke:
    """Carve a shape with a rounded edge of about `blend` millimetres."""
    return Stroke(shape, blend, carve=True)


@dataclass(frozen=True)
class Sculpture:
    """Strokes one after another on a first shape, mirrored at the mid-sagittal plane: only x >= 0 is described."""

    strokes: Sequence[Stroke]

    def distance(self, points: FloatArray) -> FloatArray:
        """Values (n,) at points (n, 3)."""
        folded = np.column_stack([np.abs(points[:, 0]), points[:, 1:]])
        result = self.strokes[0].shape.distance(folded)
        for stroke in self.strokes[1:]:
            value = stroke.shape.distance(folded)
            if stroke.carve:
                result = smooth_maximum(result, -value, stroke.blend)
            else:
                result = smooth_minimum(result, value, stroke.blend)
        return result

    def gradient(self, points: FloatArray, step: float = 0.05) -> FloatArray:
        """Gradient (n, 3) by central differences."""
        shifts = step * np.eye(3)
        columns = [self.distance(points + shift) - self.distance(points - shift) for shift in shifts]
        return np.stack(columns, axis=1) / (2.0 * step)


def smooth_minimum(first: FloatArray, second: FloatArray, blend: float) -> FloatArray:
    """Minimum with a fillet of about `blend` (polynomial smooth minimum, Quilez 2013)."""
    share = np.clip(0.5 + 0.5 * (second - first) / blend, 0.0, 1.0)
    result: FloatArray = second * (1.0 - share) + first * share - blend * share * (1.0 - share)
    return result


def smooth_maximum(first: FloatArray, second: FloatArray, blend: float) -> FloatArray:
    """Maximum with a fillet of about `blend`."""
    return -smooth_minimum(-first, -second, blend)
