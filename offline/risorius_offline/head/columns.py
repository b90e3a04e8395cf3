"""Columns of tissue: from each (u, v) of the chart a straight line through it, from the skin to the deep side.

They leave the skin half way between the chart's ray and the normal of the smoothed skin, so that cells stand upright
where rays graze: beside the nose, on the neck. At lids and lips they are the rays, along which the openings' walls run.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import RegularGridInterpolator
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree

from risorius.jaw import FloatArray
from risorius_offline.head import chart
from risorius_offline.head.depths import THINNEST, DepthField
from risorius_offline.head.openings import lip_lines
from risorius_offline.head.sheet import LOWER, UPPER
from risorius_offline.head.skin import SKIN, distance_to_eye
from risorius_offline.head.skull import DEEP

# Millimetres from the eyeball's centre within which it decides alone on thickness, and beyond which it does not.
NEAR_EYE = (14.5, 22.0)
LATTICE, BEYOND = 2.0, 20.0  # millimetres of the chart
SMOOTHING = 5.0
UPRIGHT = 0.5  # the normal's share
# Millimetres from the eyeball's centre and from the lips' line between which the normal comes in.
FROM_EYE, FROM_LIPS = (17.0, 26.0), (4.0, 14.0)
WEIGHT_SMOOTHING = 3.0
GRAZING = (0.75, 0.45)  # cosine between ray and normal, from which and up to which it comes in
CHIN_FROM, CHIN_TO = (-40.0, -50.0), (-95.0, -88.0)  # heights between which rays are kept, as the jaw moves there


@dataclass(frozen=True)
class Column:
    """skin (n, 3): where columns begin; inward (n, 3): unit vectors; thickness (n,). Millimetres."""

    skin: FloatArray
    inward: FloatArray
    thickness: FloatArray

    def at(self, depth: FloatArray) -> FloatArray:
        """Points (n, 3) at distances (n,) below the skin."""
        result: FloatArray = self.skin + depth[:, None] * self.inward
        return result


class Columns:
    """All columns of the face."""

    def __init__(self) -> None:
        self._depths = DepthField()
        self._inward = _directions()

    def at(self, uv: FloatArray) -> Column:
        """Columns at (n, 2); those of mirror images are mirror images to the last bit."""
        folded, which = np.unique(np.column_stack([np.abs(uv[:, 0]), uv[:, 1]]), axis=0, return_inverse=True)
        half = self._left(folded)
        side = np.column_stack([np.sign(uv[:, 0]), np.ones((len(uv), 2))])
        return Column(side * half.skin[which], side * half.inward[which], half.thickness[which])

    def _left(self, uv: FloatArray) -> Column:
        """Columns at (n, 2) of the left half."""
        origins, directions = chart.rays(uv)
        skin = origins + chart.outermost(SKIN, uv)[:, None] * directions
        inward = _unit(self._inward(uv))
        sculpted = chart.way_in(DEEP, skin, inward)
        limited = self._depths.limited(uv, sculpted)
        share = _ramp(distance_to_eye(skin), NEAR_EYE)
        share = share**2 * (3.0 - 2.0 * share)
        return Column(skin, inward, np.maximum(share * limited + (1.0 - share) * sculpted, THINNEST))


def _directions() -> RegularGridInterpolator:
    """Inward directions over u >= 0 and v."""
    u = np.arange(0.0, UPPER[0] + BEYOND, LATTICE)
    v = np.arange(LOWER[1] - BEYOND, UPPER[1] + BEYOND, LATTICE)
    uv = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
    origins, directions = chart.rays(uv)
    skin = origins + chart.outermost(SKIN, uv)[:, None] * directions
    shape = (len(u), len(v), 3)
    normals = _unit(_smooth(_unit(SKIN.gradient(skin)).reshape(shape), SMOOTHING, odd=(0,)))
    to_lips = cKDTree(np.concatenate(lip_lines())).query(skin)[0]
    cosine = (_unit(SKIN.gradient(skin)) * directions).sum(axis=1)
    weight = np.minimum.reduce([
        _ramp(distance_to_eye(skin), FROM_EYE), _ramp(to_lips, FROM_LIPS), _ramp(cosine, GRAZING),
        1.0 - np.minimum(_ramp(skin[:, 1], CHIN_FROM), _ramp(skin[:, 1], CHIN_TO)),
    ])  # fmt: skip
    weight = UPRIGHT * _smooth(weight.reshape(len(u), len(v), 1), WEIGHT_SMOOTHING)
    outward = weight * normals + (1.0 - weight) * directions.reshape(shape)
    return RegularGridInterpolator((u, v), -_unit(outward))


def _ramp(value: FloatArray, ends: tuple[float, float]) -> FloatArray:
    """0 up to the first end, 1 from the second."""
    result: FloatArray = np.clip((value - ends[0]) / (ends[1] - ends[0]), 0.0, 1.0)
    return result


def _smooth(values: FloatArray, width: float, odd: tuple[int, ...] = ()) -> FloatArray:
    """Values (i, j, k) over u >= 0 and v smoothed over both; width in millimetres of the chart.

    Components k that are odd change sign at u = 0.
    """
    other = values[:0:-1].copy()
    other[..., odd] *= -1.0
    both = gaussian_filter(np.concatenate([other, values]), (width / LATTICE, width / LATTICE, 0.0))
    result: FloatArray = both[len(other) :]
    return result


def _unit(vectors: FloatArray) -> FloatArray:
    result: FloatArray = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return result
