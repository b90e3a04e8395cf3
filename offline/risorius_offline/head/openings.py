"""Lines on the neutral face at which its skin ends: the lips' line and the lid margins, left half, in millimetres."""

from __future__ import annotations

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.head.skin import EYE_CENTRE, EYE_RADIUS

MOUTH_HALF_WIDTH = 25.0
LIP_GAP = 0.35  # half the distance between the lips' lines at the midline
LIP_LINE = ((0.0, -45.6, 102.4), (5.0, -45.1, 102.0), (14.0, -45.8, 98.5), (20.0, -46.0, 94.0), (25.0, -46.1, 88.5))
FISSURE_MIDDLE, FISSURE_HALF_WIDTH = 29.8, 12.6
FISSURE_HEIGHT, FISSURE_SLANT = 17.2, 0.06
UPPER_RISE, LOWER_FALL = 5.4, 3.8
MARGIN_ABOVE_GLOBE = 1.3


def lip_lines(count: int = 60) -> tuple[FloatArray, FloatArray]:
    """Upper and lower line (count, 3) from the midline to the corner, where they meet."""
    table = np.array(LIP_LINE)
    x = MOUTH_HALF_WIDTH * np.sin(np.linspace(0.0, np.pi / 2.0, count))
    line = np.column_stack([x, *(np.interp(x, table[:, 0], table[:, k]) for k in (1, 2))])
    gap = LIP_GAP * np.sqrt(np.clip(1.0 - (x / MOUTH_HALF_WIDTH) ** 2, 0.0, 1.0))
    shift = np.column_stack([np.zeros(count), gap, np.zeros(count)])
    return line + shift, line - shift


def lid_margins(count: int = 60) -> tuple[FloatArray, FloatArray]:
    """Margins (count, 3) of the upper and the lower lid of the left eye, from the inner to the outer corner."""
    t = -np.cos(np.linspace(0.0, np.pi, count))
    round_off = np.sqrt(np.clip(1.0 - t**2, 0.0, 1.0))
    x = FISSURE_MIDDLE + FISSURE_HALF_WIDTH * t
    level = FISSURE_HEIGHT + FISSURE_SLANT * FISSURE_HALF_WIDTH * t
    upper = level + UPPER_RISE * round_off**1.1 * (1.0 - 0.12 * t)
    lower = level - LOWER_FALL * round_off**1.2 * (1.0 + 0.12 * t)
    return _on_globe(x, upper), _on_globe(x, lower)


def _on_globe(x: FloatArray, y: FloatArray) -> FloatArray:
    radius = EYE_RADIUS + MARGIN_ABOVE_GLOBE
    away = (x - EYE_CENTRE[0]) ** 2 + (y - EYE_CENTRE[1]) ** 2
    return np.column_stack([x, y, EYE_CENTRE[2] + np.sqrt(radius**2 - away)])
