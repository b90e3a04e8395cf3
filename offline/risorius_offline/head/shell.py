"""Layers of wedges between skin and deep surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray
from risorius_offline.head.columns import Columns
from risorius_offline.head.sheet import Sheet

SKIN_THICKNESS, LARGEST_SKIN_SHARE = 1.8, 0.33
FRACTIONS = (0.0, 0.42, 0.70)  # of the tissue below the skin, from deep to superficial


@dataclass(frozen=True)
class Shell:
    """points (levels * n, 3) millimetres, level by level from deep to skin; wedges (k, 6) and their layer (k,)."""

    points: FloatArray
    wedges: IntArray
    layer: IntArray
    level_size: int
    columns: Columns

    def at(self, uv: FloatArray, depth: FloatArray) -> FloatArray:
        """Points (k, 3) at a share of the way (k,) from the deep surface to the skin."""
        column = self.columns.at(uv)
        return column.at((1.0 - depth) * column.thickness)


def layered_shell(sheet: Sheet) -> Shell:
    """Wedges of all layers, numbered as in `anatomy.layers`: skin, superficial fat, muscle, deep fat."""
    columns = Columns()
    column = columns.at(sheet.uv)
    skin = np.minimum(SKIN_THICKNESS, LARGEST_SKIN_SHARE * column.thickness)
    below = column.thickness - skin
    depths = [column.thickness - fraction * below for fraction in FRACTIONS] + [skin, np.zeros_like(skin)]
    points = np.concatenate([column.at(depth) for depth in depths])
    count = len(sheet.uv)
    lower = [sheet.triangles + k * count for k in range(len(depths) - 1)]
    wedges = np.concatenate([np.hstack([t, t + count]) for t in lower])
    layer = np.repeat(np.arange(len(lower))[::-1], len(sheet.triangles))
    return Shell(points, wedges, layer, count, columns)
