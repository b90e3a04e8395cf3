"""Layers of wedges between skin and deep surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray
from risorius_offline.head import chart
from risorius_offline.head.depths import THINNEST, DepthField
from risorius_offline.head.sheet import Sheet
from risorius_offline.head.skin import SKIN, distance_to_eye
from risorius_offline.head.skull import DEEP

SKIN_THICKNESS, LARGEST_SKIN_SHARE = 1.8, 0.33
FRACTIONS = (0.0, 0.42, 0.70)  # of the tissue below the skin, from deep to superficial
# Millimetres from the eyeball's centre within which it decides alone, and beyond which it does not.
NEAR_EYE = (14.5, 22.0)


@dataclass(frozen=True)
class Shell:
    """points (levels * n, 3) millimetres, level by level from deep to skin; wedges (k, 6) and their layer (k,)."""

    points: FloatArray
    wedges: IntArray
    layer: IntArray
    level_size: int
    depths: DepthField

    def at(self, uv: FloatArray, depth: FloatArray) -> FloatArray:
        """Points (k, 3) at a share of the way (k,) from the deep surface to the skin."""
        origins, directions = chart.rays(uv)
        outer, thickness = _outer_and_thickness(self.depths, uv)
        result: FloatArray = origins + (outer - (1.0 - depth) * thickness)[:, None] * directions
        return result


def layered_shell(sheet: Sheet) -> Shell:
    """Wedges of all layers, numbered as in `anatomy.layers`: skin, superficial fat, muscle, deep fat."""
    origins, directions = chart.rays(sheet.uv)
    depths = DepthField()
    outer, thickness = _outer_and_thickness(depths, sheet.uv)
    skin = np.minimum(SKIN_THICKNESS, LARGEST_SKIN_SHARE * thickness)
    below = thickness - skin
    heights = [outer - thickness + fraction * below for fraction in FRACTIONS] + [outer - skin, outer]
    points = np.concatenate([origins + height[:, None] * directions for height in heights])
    count = len(sheet.uv)
    lower = [sheet.triangles + k * count for k in range(len(heights) - 1)]
    wedges = np.concatenate([np.hstack([t, t + count]) for t in lower])
    layer = np.repeat(np.arange(len(lower))[::-1], len(sheet.triangles))
    return Shell(points, wedges, layer, count, depths)


def _outer_and_thickness(depths: DepthField, uv: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distance (n,) of the skin along the rays, and thickness (n,) of the tissue beneath."""
    origins, directions = chart.rays(uv)
    outer = chart.outermost(SKIN, uv)
    skin = origins + outer[:, None] * directions
    sculpted = outer - chart.outermost(DEEP, uv)
    limited = depths.limited(uv, sculpted)
    share = np.clip((distance_to_eye(skin) - NEAR_EYE[0]) / (NEAR_EYE[1] - NEAR_EYE[0]), 0.0, 1.0)
    share = share**2 * (3.0 - 2.0 * share)
    result: FloatArray = np.maximum(share * limited + (1.0 - share) * sculpted, THINNEST)
    return outer, result
