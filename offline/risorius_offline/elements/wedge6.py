"""Linear wedge, 3 points in the triangle x 2 along the axis.

The rule is put together here: the one that scikit-fem 12 gives for wedges sums to half of the reference volume.
"""

import numpy as np
import skfem
from skfem.quadrature import get_quadrature

from risorius_offline.elements.reference import ReferenceElement

_TRIANGLE, _TRIANGLE_WEIGHTS = get_quadrature(skfem.ElementTriP1().refdom, 2)
_LINE, _LINE_WEIGHTS = get_quadrature(skfem.ElementLineP1().refdom, 2)
_POINTS = np.vstack([np.repeat(_TRIANGLE, _LINE.shape[1], axis=1), np.tile(_LINE, _TRIANGLE.shape[1])])
_WEIGHTS = np.outer(_TRIANGLE_WEIGHTS, _LINE_WEIGHTS).ravel()

WEDGE6 = ReferenceElement(
    cell_type="wedge",
    nodes=((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)),
    basis=skfem.ElementWedge1(),
    points=_POINTS,
    weights=_WEIGHTS,
    mass_rule=(_POINTS, _WEIGHTS),
    corners=6,
    faces=((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
)
