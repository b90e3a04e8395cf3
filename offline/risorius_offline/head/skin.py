"""The skin of the neutral head, sculpted in millimetres.

Frame of this table: x to the person's left, y up, z out of the face; origin midway between the tragions, y = 0 in the
Frankfurt plane.
"""

from __future__ import annotations

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.head.implicit import Ellipsoid, Sculpture, Sweep, add, carve

EYE_CENTRE = (30.2, 17.0, 66.5)
EYE_RADIUS = 13.0
LID_THICKNESS = 2.4
NOSTRIL = Ellipsoid((5.9, -25.3, 104.0), (3.2, 3.2, 5.0), yaw=-15)

CRANIUM = (
    add(Ellipsoid((0, 52, -2), (73, 80, 94)), 0),
    add(Ellipsoid((0, 55, 38), (60, 55, 57)), 25),
    add(Ellipsoid((26, 66, 58), (30, 24, 32)), 30),
)
MIDFACE = (
    add(Ellipsoid((0, -8, 42), (52, 56, 49)), 22),
    add(Ellipsoid((0, -36, 58), (36, 30, 36)), 18),
    add(Ellipsoid((39, -7, 55), (19, 16, 20), yaw=-35), 20),
    add(Sweep(((46, -3, 54), (57, 0, 14)), (8.0, 8.0)), 20),
)
JAW = (
    add(Sweep(((52, -8, 10), (42, -50, 20)), (12, 9.5)), 22),
    add(Ellipsoid((38, -28, 36), (17, 32, 26), yaw=-8), 20),
    add(Sweep(((42, -52, 22), (30, -67, 52), (12, -78, 74)), (10, 10.5, 12)), 22),
    add(Ellipsoid((0, -78, 79.5), (17, 12.5, 14.5)), 14),
    add(Ellipsoid((0, -58, 45), (37, 20, 39)), 16),
    add(Ellipsoid((36, -30, 51), (21, 27, 24.5)), 18),
)
BROW = (
    add(Sweep(((8, 31.5, 84.0), (24, 35, 82.5), (38, 34, 76)), (6.5, 7.0, 6.5)), 14),
    add(Sweep(((38, 34, 75), (51, 24, 58)), (6.0, 6)), 18),
    carve(Ellipsoid((31, 15.0, 92), (17.0, 11.5, 13.5), yaw=12), 14),
    carve(Ellipsoid((16.5, 17, 98), (5.5, 9, 14)), 10),
)
NOSE = (
    add(Sweep(((0, 30, 86), (0, 12, 91.5), (0, -4, 102.5), (0, -13, 109.5)), (7.0, 5.6, 5.6, 7.0)), 8),
    add(Ellipsoid((0, -14.0, 109.0), (8.2, 7.2, 8.8)), 6),
    add(Ellipsoid((5.5, -4, 94), (8.5, 16, 9)), 9),
    add(Ellipsoid((10.4, -18.6, 101.0), (5.6, 6.4, 8.6), yaw=-22), 6),
    add(Ellipsoid((0, -20.5, 103.5), (3.8, 5.6, 8.6)), 4),
    carve(Sweep(((16.8, -11, 102.5), (18.0, -18, 101.5), (17.4, -25, 98.5)), (0.6, 0.9, 0.8)), 5),
    carve(NOSTRIL, 2.0),
)
MOUTH = (
    add(Ellipsoid((0, -36, 75), (26, 13, 21.5)), 12),
    carve(Sweep(((0, -29, 104.0), (0, -37, 103.5)), (1.2, 2.6)), 4),
    add(
        Sweep(
            ((0, -41.6, 96.0), (5, -40.6, 96.0), (13, -42.2, 92.6), (20, -44.4, 87.5), (25, -45.9, 82)),
            (4.3, 4.6, 4.0, 3.0, 1.8),
        ),
        2.6,
    ),
    add(
        Sweep(
            ((0, -50.4, 94.0), (8, -50.2, 93.2), (15, -49.0, 89.8), (20, -47.6, 86.2), (25, -46.2, 82)),
            (5.3, 5.1, 4.3, 3.3, 1.8),
        ),
        2.6,
    ),
    carve(Ellipsoid((0, -62.0, 106), (18, 5.0, 9)), 9),
    carve(Ellipsoid((32, -47, 91.5), (3.0, 5, 4.0), yaw=28), 9),
    carve(
        Sweep(
            ((0, -45.6, 102.4), (5, -45.1, 102), (14, -45.8, 98.5), (20, -46.0, 94), (25.5, -46.1, 88)),
            (0.7, 0.7, 0.7, 0.7, 0.6),
        ),
        2.0,
    ),
)
EYES = (add(Ellipsoid(EYE_CENTRE, (EYE_RADIUS + LID_THICKNESS,) * 3), 7),)
NECK = (add(Sweep(((0, -30, -28), (0, -150, -40)), (48, 54)), 26),)

SKIN = Sculpture((*CRANIUM, *MIDFACE, *JAW, *BROW, *NOSE, *MOUTH, *EYES, *NECK))


def distance_to_eye(points: FloatArray) -> FloatArray:
    """Distance (n,) of points (n, 3) to the centre of the eyeball on their side."""
    folded = np.column_stack([np.abs(points[:, 0]), points[:, 1:]])
    result: FloatArray = np.linalg.norm(folded - np.asarray(EYE_CENTRE), axis=1)
    return result
