"""Quadratic tetrahedron, four points."""

import skfem

from risorius_offline.elements.reference import ReferenceElement, gauss
from risorius_offline.elements.tet4 import TET4

_BASIS = skfem.ElementTetP2()
_POINTS, _WEIGHTS = gauss(_BASIS, 2)

TET10 = ReferenceElement(
    cell_type="tetra10",
    nodes=(*TET4.nodes, (0.5, 0, 0), (0.5, 0.5, 0), (0, 0.5, 0), (0, 0, 0.5), (0.5, 0, 0.5), (0, 0.5, 0.5)),
    basis=_BASIS,
    points=_POINTS,
    weights=_WEIGHTS,
    mass_rule=gauss(_BASIS, 4),
    corners=4,
    faces=TET4.faces,
    jacobian=((3, 3),),
)
