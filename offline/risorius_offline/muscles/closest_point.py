"""The point of a smooth curve that is closest to a point in space, by Newton's method on the curve's parameter."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from scipy.spatial import cKDTree

from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray

# Position, first and second derivative, each (k, 3), at parameters (k,).
Curve: TypeAlias = Callable[[FloatArray], tuple[FloatArray, FloatArray, FloatArray]]
ITERATIONS = 20


def closest_parameters(
    points: FloatArray, curve: Curve, samples: FloatArray, bounds: tuple[float, float], reach: float
) -> tuple[IntArray, FloatArray]:
    """Numbers (k,) of the points (n, 3) that may lie within `reach` of the curve, and the closest parameters (k,).

    samples (m,): parameters along all of the curve, dense against its bends; the search starts from the nearest one.
    bounds: least and largest parameter, infinite for a closed curve. Some points beyond `reach` are among those kept.
    """
    positions = curve(samples)[0]
    spacing = float(np.linalg.norm(np.diff(positions, axis=0), axis=1).max())
    distance, nearest = cKDTree(positions).query(points)
    near = np.flatnonzero(distance <= reach + spacing)
    t = samples[nearest[near]]
    for _ in range(ITERATIONS):
        position, first, second = curve(t)
        offset = position - points[near]
        slope = np.einsum("ki,ki->k", offset, first)
        curvature = np.einsum("ki,ki->k", first, first)
        exact = curvature + np.einsum("ki,ki->k", offset, second)
        # Beyond the centre of curvature the distance has no minimum to aim for; the Gauss-Newton step still descends.
        step = slope / np.where(exact > 0.1 * curvature, exact, curvature)
        t = np.clip(t - step, *bounds)
    return near, t
