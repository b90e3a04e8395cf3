"""Linear tetrahedron, one point."""

import skfem

from risorius_offline.elements.reference import ReferenceElement, gauss

_BASIS = skfem.ElementTetP1()
_POINTS, _WEIGHTS = gauss(_BASIS, 1)

TET4 = ReferenceElement(
    cell_type="tetra",
    nodes=((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)),
    basis=_BASIS,
    points=_POINTS,
    weights=_WEIGHTS,
    mass_rule=gauss(_BASIS, 2),
    corners=4,
    faces=((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    jacobian=((3, 0),),
)
