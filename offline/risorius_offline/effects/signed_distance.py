"""Distance to a bone as a twice continuously differentiable function: cubic B-splines on a regular grid.

The distance itself has kinks: beside edges outside, on the medial axis inside. Here its samples are the coefficients of
the splines, not their values. That smooths it over about the spacing h: planes are exact, a sphere of radius R recedes
by h^2 / (3 R), nothing overshoots. With the spacing of the nodes that slide on it, bumps finer than the tissue's mesh,
into which single nodes would fall, vanish: tissue slides, and Newton's method converges.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.anatomy.anatomy import Surface
from risorius_offline.effects.triangle_distance import signed_distances

_compiled = numba.njit(cache=True, error_model="numpy")

# Grid cells to either side of the surface in which the distance is exact.
BAND = 4
# Grid cells between the band and the end of the grid: the spline ends at the band's width, as it goes on beyond.
MARGIN = 4


@dataclass(frozen=True)
class SignedDistance:
    """Distance to a bone in metres, negative inside, cut off at +-band; beyond the grid it is the band: far.

    origin (3,) and spacing of the grid in metres, coefficients (nx, ny, nz) of the B-splines in metres.
    """

    origin: FloatArray
    spacing: float
    band: float
    coefficients: FloatArray

    @classmethod
    def of(cls, surface: Surface, spacing: float = 1.5e-3) -> SignedDistance:
        """Distance to a surface, which may be open; raises InputError for one whose sides cannot be told.

        The grid lies about the middle of the surface: mirror images have distances that are mirror images.
        """
        band = BAND * spacing
        low, high = surface.points.min(axis=0), surface.points.max(axis=0)
        nx, ny, nz = (int(n) + 2 for n in (high - low + 2.0 * (band + MARGIN * spacing)) / spacing)
        origin = 0.5 * (low + high) - 0.5 * spacing * (np.array([nx, ny, nz]) - 1)
        return cls(origin, spacing, band, signed_distances(surface, origin, spacing, (nx, ny, nz), band))

    def values(self, points: FloatArray) -> FloatArray:
        """Distances (k,) of points (k, 3)."""
        result = np.empty(len(points))
        _values(self.coefficients, self.origin, self.spacing, self.band, points, result)
        return result

    def derivatives(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gradients (k, 3) and second derivatives (k, 3, 3), per metre, at points (k, 3); zero beyond the grid."""
        gradients, hessians = np.zeros((len(points), 3)), np.zeros((len(points), 3, 3))
        _derivatives(self.coefficients, self.origin, self.spacing, points, gradients, hessians)
        return gradients, hessians


@_compiled
def _locate(shape, origin, spacing, point, start, weights):  # type: ignore[no-untyped-def]
    """First coefficients (3,) and B-spline weights (axis, order of derivative, 4) at a point; False beyond the grid."""
    for axis in range(3):
        position = (point[axis] - origin[axis]) / spacing
        cell = math.floor(position)
        if not 1 <= cell <= shape[axis] - 3:
            return False
        start[axis] = cell - 1
        t = position - cell
        s = 1.0 - t
        w = weights[axis]
        w[0, 0], w[0, 1] = s**3 / 6, 2 / 3 - t * t * (1 - t / 2)
        w[0, 2], w[0, 3] = 2 / 3 - s * s * (1 - s / 2), t**3 / 6
        w[1, 0], w[1, 1], w[1, 2], w[1, 3] = -s * s / 2, t * (1.5 * t - 2), -s * (1.5 * s - 2), t * t / 2
        w[2, 0], w[2, 1], w[2, 2], w[2, 3] = s, 3 * t - 2, 3 * s - 2, t
    return True


@_compiled
def _values(coefficients, origin, spacing, far, points, values):  # type: ignore[no-untyped-def]
    start, weights = np.empty(3, np.int64), np.empty((3, 3, 4))
    for n in range(len(points)):
        if not _locate(coefficients.shape, origin, spacing, points[n], start, weights):
            values[n] = far
            continue
        total = 0.0
        for i in range(4):
            for j in range(4):
                line = 0.0
                for k in range(4):
                    line += weights[2, 0, k] * coefficients[start[0] + i, start[1] + j, start[2] + k]
                total += weights[0, 0, i] * weights[1, 0, j] * line
        values[n] = total


@_compiled
def _derivatives(coefficients, origin, spacing, points, gradients, hessians):  # type: ignore[no-untyped-def]
    start, weights = np.empty(3, np.int64), np.empty((3, 3, 4))
    for n in range(len(points)):
        if not _locate(coefficients.shape, origin, spacing, points[n], start, weights):
            continue
        x, y, z = weights
        G, H = gradients[n], hessians[n]
        for i in range(4):
            for j in range(4):
                for k in range(4):
                    c = coefficients[start[0] + i, start[1] + j, start[2] + k]
                    G[0] += c * x[1, i] * y[0, j] * z[0, k]
                    G[1] += c * x[0, i] * y[1, j] * z[0, k]
                    G[2] += c * x[0, i] * y[0, j] * z[1, k]
                    H[0, 0] += c * x[2, i] * y[0, j] * z[0, k]
                    H[1, 1] += c * x[0, i] * y[2, j] * z[0, k]
                    H[2, 2] += c * x[0, i] * y[0, j] * z[2, k]
                    H[0, 1] += c * x[1, i] * y[1, j] * z[0, k]
                    H[1, 2] += c * x[0, i] * y[1, j] * z[1, k]
                    H[2, 0] += c * x[1, i] * y[0, j] * z[1, k]
        G /= spacing
        H[1, 0], H[2, 1], H[0, 2] = H[0, 1], H[1, 2], H[2, 0]
        H /= spacing * spacing
