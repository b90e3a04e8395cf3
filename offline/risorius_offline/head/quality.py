"""Shape of wedges."""

from __future__ import annotations

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray

_NEIGHBOURS = ((1, 2, 3), (2, 0, 4), (0, 1, 5), (5, 4, 0), (3, 5, 1), (4, 3, 2))  # of each corner, right-handed


def scaled_jacobians(points: FloatArray, wedges: IntArray) -> FloatArray:
    """(k, 6) determinant of the unit edges at each corner of wedges (k, 6), 1 for a right prism on an even triangle."""
    corners = points[wedges]
    edges = corners[:, np.array(_NEIGHBOURS)] - corners[:, :, None]
    result: FloatArray = np.linalg.det(edges / np.linalg.norm(edges, axis=-1, keepdims=True)) * 2.0 / np.sqrt(3.0)
    return result
