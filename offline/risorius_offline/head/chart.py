"""Chart of the face: rays from inside the head, one for each (u, v), on which skin and deep surface are found.

u is the angle about the vertical times 70 mm, v runs from the neck over the chin to the top of the forehead.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.head.implicit import Sculpture

RADIUS = 70.0
# v, height and depth of the ray's origin in the mid-sagittal plane, its elevation in degrees
_ROWS = np.array([
    [-175, -22, -34, -70.5], [-160, -22, -27, -70], [-145, -20, -14, -69], [-128, -18, 1, -66],
    [-113, -15, 8, -59], [-95, -12, 10, -48.5], [-80, -10, 10, -40],
    [-63, -6, 10, -33.5], [-45, 0, 10, -26.7], [-25, 6, 10, -18.5], [0, 12, 10, -8], [17, 20, 10, -2],
    [30, 30, 10, 2.5], [60, 40, 8, 19], [85, 42, 4, 36], [105, 44, 0, 50],
])  # fmt: skip
_HEIGHT, _DEPTH, _ELEVATION = (PchipInterpolator(_ROWS[:, 0], _ROWS[:, k]) for k in (1, 2, 3))
FARTHEST, NEAREST, STEPS, BISECTIONS = 170.0, 20.0, 100, 18


def rays(uv: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Origins and unit directions, (n, 3) each, of the rays at (n, 2)."""
    elevation, azimuth = np.radians(_ELEVATION(uv[:, 1])), uv[:, 0] / RADIUS
    origins = np.column_stack([np.zeros(len(uv)), _HEIGHT(uv[:, 1]), _DEPTH(uv[:, 1])])
    level = np.cos(elevation)
    return origins, np.column_stack([np.sin(azimuth) * level, np.sin(elevation), np.cos(azimuth) * level])


def coordinates(points: FloatArray) -> FloatArray:
    """Chart coordinates (n, 2) of points (n, 3) in front of the ray origins."""
    rows = np.linspace(_ROWS[0, 0], _ROWS[-1, 0], 4001)
    heights, depths, elevations = _HEIGHT(rows), _DEPTH(rows), np.radians(_ELEVATION(rows))
    result = np.empty((len(points), 2))
    for k, (x, y, z) in enumerate(points):
        off = np.arctan2(y - heights, np.hypot(x, z - depths)) - elevations
        row = int(np.flatnonzero(np.diff(np.sign(off)))[0])
        share = off[row] / (off[row] - off[row + 1])
        v = rows[row] + share * (rows[row + 1] - rows[row])
        result[k] = RADIUS * np.arctan2(x, z - _DEPTH(v)), v
    return result


def outermost(sculpture: Sculpture, uv: FloatArray) -> FloatArray:
    """Distance (n,) along each ray to the last surface on it; raises InputError where a ray meets none."""
    origins, directions = rays(uv)
    return FARTHEST - way_in(sculpture, origins + FARTHEST * directions, -directions)


def way_in(sculpture: Sculpture, starts: FloatArray, directions: FloatArray) -> FloatArray:
    """Distance (n,) from (n, 3) along unit vectors to the first surface; raises InputError where there is none."""
    outside = np.zeros(len(starts))
    inside = np.full(len(starts), np.nan)
    step = (FARTHEST - NEAREST) / STEPS
    active = np.arange(len(starts))
    for k in range(1, STEPS + 1):
        at = k * step
        hit = sculpture.distance(starts[active] + at * directions[active]) < 0.0
        inside[active[hit]] = at
        active = active[~hit]
        outside[active] = at
        if not len(active):
            break
    if len(active):
        x, y, z = starts[active[0]]
        raise InputError(f"the line from ({x:.1f}, {y:.1f}, {z:.1f}) meets no surface; make the chart smaller")
    for _ in range(BISECTIONS):
        middle = 0.5 * (inside + outside)
        within = sculpture.distance(starts + middle[:, None] * directions) < 0.0
        inside, outside = np.where(within, middle, inside), np.where(within, outside, middle)
    return 0.5 * (inside + outside)
