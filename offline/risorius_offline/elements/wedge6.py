"""Linear wedge, 3 points in the triangle x 2 along the axis."""

import skfem

from risorius_offline.elements.reference import ReferenceElement, gauss

_BASIS = skfem.ElementWedge1()
_POINTS, _WEIGHTS = gauss(_BASIS, 2)

WEDGE6 = ReferenceElement(
    cell_type="wedge",
    nodes=((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)),
    basis=_BASIS,
    points=_POINTS,
    weights=_WEIGHTS,
    mass_rule=(_POINTS, _WEIGHTS),
    corners=6,
    faces=((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    jacobian=((2, 1), (1, 2)),
)
