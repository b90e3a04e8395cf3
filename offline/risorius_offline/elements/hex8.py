"""Trilinear hexahedron, 2 x 2 x 2 points."""

import skfem

from risorius_offline.elements.reference import ReferenceElement, gauss

_BASIS = skfem.ElementHex1()
_POINTS, _WEIGHTS = gauss(_BASIS, 2)

HEX8 = ReferenceElement(
    cell_type="hexahedron",
    nodes=((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)),
    basis=_BASIS,
    points=_POINTS,
    weights=_WEIGHTS,
    mass_rule=(_POINTS, _WEIGHTS),
    corners=8,
    faces=((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    jacobian=((1, 2), (1, 2), (1, 2)),
)
