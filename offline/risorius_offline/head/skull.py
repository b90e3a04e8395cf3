"""The deep side of the face, sculpted in millimetres in the frame of `skin.py`: bones with teeth, and the eyeballs.

What lies between them, where soft tissue ends on no bone (cheeks, floor of the mouth, front of the neck), is closed by
the shapes of `HOLLOWS`; tissue is free there.
"""

from __future__ import annotations

from risorius_offline.head.implicit import Ellipsoid, Sculpture, Sweep, add, carve
from risorius_offline.head.skin import EYE_CENTRE, EYE_RADIUS

INCISAL_EDGE = (0.0, -47.0, 88.0)  # of the lower central incisors

CRANIUM = (
    add(Ellipsoid((0, 52, -2), (69, 75, 90)), 0),
    add(Ellipsoid((0, 55, 36), (56, 50, 55)), 25),
    add(Ellipsoid((26, 64, 54), (27, 22, 32)), 30),
    add(Sweep(((8, 30, 81), (24, 34, 79), (38, 33, 71)), (5, 5, 5)), 10),
    add(Sweep(((38, 33, 71), (50, 22, 54)), (5, 5)), 12),
    add(Ellipsoid((0, -8, 40), (36, 44, 43)), 18),
    add(Sweep(((33, -8, 58), (50, -5, 43), (60, 0, 12)), (7, 6, 4.5)), 10),
    add(Sweep(((0, 26, 82), (0, 13, 87), (0, 4, 97)), (4.5, 4, 4)), 6),
    add(Sweep(((20, -2, 75.5), (32, -5, 72.5), (44, -3, 65.5)), (4, 4, 4)), 6),
    add(Ellipsoid((0, -14, 82), (9, 13, 12)), 8),
    add(Ellipsoid((0, -33, 60), (25, 15, 28.5)), 10),
)
MANDIBLE = (
    add(Sweep(((51, -6, 6), (44, -50, 15)), (6, 6)), 0),
    add(Sweep(((44, -51, 16), (29, -64, 46), (12, -73, 70)), (6.5, 7, 8.5)), 8),
    add(Ellipsoid((0, -73, 74.5), (14, 11.5, 10.5)), 8),
    add(Ellipsoid((0, -55, 58), (24, 12, 28.5)), 10),
)
HOLLOWS = (
    add(Ellipsoid((24, -32, 36), (17, 32, 26)), 12),
    add(Ellipsoid((0, -50, 40), (30, 22, 34)), 12),
    add(Sweep(((0, -30, -28), (0, -150, -40)), (40, 46)), 20),
)
ABOVE_THE_CHIN = carve(Ellipsoid((0, -63, 92), (17, 9, 10.5)), 8)  # where the mandible recedes
GLOBE = Ellipsoid(EYE_CENTRE, (EYE_RADIUS + 0.2,) * 3)

BONES = (*CRANIUM, *(add(s.shape, max(s.blend, 8.0)) for s in MANDIBLE))
DEEP = Sculpture((*BONES, *HOLLOWS, ABOVE_THE_CHIN, add(GLOBE, 3)))
