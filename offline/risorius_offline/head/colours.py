"""Colours of the built-in head: skin, lips, brows, what shows in mouth and eyes; sRGB, blended over a millimetre."""

from __future__ import annotations

import numpy as np

from risorius.jaw import FloatArray
from risorius.surface import Colours
from risorius_offline.head.openings import MOUTH_HALF_WIDTH

SKIN, LIPS, BROWS = (217, 165, 139), (178, 98, 92), (66, 46, 36)
MOUTH_LINING, LID_LINING = (122, 50, 50), (205, 140, 122)
SCLERA, IRIS, PUPIL = (240, 236, 230), (92, 126, 138), (18, 18, 18)
TEETH, GUMS, TONGUE, THROAT = (236, 228, 210), (190, 110, 104), (170, 84, 80), (70, 24, 24)

_LIP_MIDDLE = -46.0
_UPPER_LIP, _CUPIDS_BOW, _LOWER_LIP = 5.4, 0.9, 8.0  # heights of the vermilion, millimetres
_BROW_X = (10.0, 17.0, 25.0, 33.0, 41.0, 48.0)
_BROW_Y = (35.0, 36.9, 38.0, 38.3, 36.8, 33.6)
_BROW_HALF_HEIGHT = (2.6, 3.0, 2.8, 2.4, 1.8, 0.8)
_BROW_COVER = 0.85


def skin_colours(points: FloatArray, lining: FloatArray) -> Colours:
    """Colours (n, 3) of visible points (n, 3) at rest; lining (n,): share of what is inside mouth and lids."""
    x, y, z = np.abs(points[:, 0]), points[:, 1], points[:, 2]
    colour = np.tile(np.array(SKIN, dtype=np.float64), (len(points), 1))
    colour = _mix(colour, LIPS, _vermilion(x, y) * (z > 75.0))
    colour = _mix(colour, BROWS, _BROW_COVER * _brow(x, y) * (z > 50.0))
    inside = np.where((y < 0.0)[:, None], np.array(MOUTH_LINING), np.array(LID_LINING))
    colour = colour + lining[:, None] * (inside - colour)
    return np.rint(colour).astype(np.uint8)


def _vermilion(x: FloatArray, y: FloatArray) -> FloatArray:
    along = np.clip(1.0 - (x / (MOUTH_HALF_WIDTH + 0.5)) ** 2, 0.0, 1.0)
    bow = _CUPIDS_BOW * (np.exp(-(((x - 5.0) / 4.0) ** 2)) - 0.5 * np.exp(-((x / 2.5) ** 2)))
    upper = _LIP_MIDDLE + (_UPPER_LIP + bow) * along**0.75
    lower = _LIP_MIDDLE - _LOWER_LIP * along**0.6
    result: FloatArray = _inside(np.minimum(upper - y, y - lower)) * (x < MOUTH_HALF_WIDTH + 1.5)
    return result


def _brow(x: FloatArray, y: FloatArray) -> FloatArray:
    off = np.abs(y - np.interp(x, _BROW_X, _BROW_Y))
    across = _inside(np.interp(x, _BROW_X, _BROW_HALF_HEIGHT) - off)
    result: FloatArray = across * _inside(_BROW_X[-1] - 1.0 - x) * _inside(x - _BROW_X[0])
    return result


def _inside(depth: FloatArray) -> FloatArray:
    """1 well inside, 0 well outside, over about a millimetre."""
    result: FloatArray = 1.0 / (1.0 + np.exp(np.clip(-depth / 0.4, -50.0, 50.0)))
    return result


def _mix(colour: FloatArray, other: tuple[int, int, int], share: FloatArray) -> FloatArray:
    return colour + share[:, None] * (np.array(other) - colour)
