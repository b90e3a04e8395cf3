"""Nostrils: hollows of the sculpture that are painted dark, since the chart's rays cannot look up into the nose."""

from __future__ import annotations

import numpy as np

from risorius.jaw import FloatArray
from risorius.surface import Colours
from risorius_offline.head.skin import NOSTRIL

DARK = (58, 26, 22)
EDGE, SOFTNESS = 1.1, 0.3  # millimetres from the hollow


def with_nostrils(colours: Colours, points: FloatArray) -> Colours:
    """Colours (n, 3) of visible points (n, 3), in millimetres at rest, dark in the nostrils."""
    left = np.column_stack([np.abs(points[:, 0]), points[:, 1:]])
    away = np.clip((NOSTRIL.distance(left) - EDGE) / SOFTNESS, -50.0, 50.0)
    share = (1.0 / (1.0 + np.exp(away)))[:, None]
    return np.rint((1.0 - share) * colours + share * DARK).astype(np.uint8)
