"""Bernstein form of det(dx/dxi), the determinant of the derivatives of a cell's map from its reference cell.

It is a polynomial, and lies between the least and the greatest of its Bernstein coefficients (Johnen, Remacle and
Geuzaine 2013, Geometrical validity of curvilinear finite elements).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, reduce

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray
from risorius_offline.elements import ELEMENTS

# By dimension, the parts of a simplex that is divided at the middles of its edges: a corner of a part lies half way
# between two corners.
PARTS = {
    1: (((0, 0), (0, 1)), ((0, 1), (1, 1))),
    2: (
        ((0, 0), (0, 1), (0, 2)),
        ((0, 1), (1, 1), (1, 2)),
        ((0, 2), (1, 2), (2, 2)),
        ((0, 1), (1, 2), (0, 2)),
    ),
    3: (
        ((0, 0), (0, 1), (0, 2), (0, 3)),
        ((0, 1), (1, 1), (1, 2), (1, 3)),
        ((0, 2), (1, 2), (2, 2), (2, 3)),
        ((0, 3), (1, 3), (2, 3), (3, 3)),
        ((0, 1), (0, 2), (0, 3), (1, 3)),
        ((0, 1), (0, 2), (1, 2), (1, 3)),
        ((0, 2), (0, 3), (1, 3), (2, 3)),
        ((0, 2), (1, 2), (1, 3), (2, 3)),
    ),
}


@dataclass(frozen=True)
class BernsteinForm:
    """Coefficients of the determinants of an element, k in number.

    gradients (k, a, 3) of the shape functions at k points of the reference cell; form (k, k) takes determinants there
    to coefficients. division (c, k, k) takes the coefficients of a cell to those of its c parts, halved along each
    axis. corners: numbers of the coefficients that are the values at corners.
    """

    gradients: FloatArray
    form: FloatArray
    division: FloatArray
    corners: IntArray

    def determinants(self, nodes: FloatArray) -> FloatArray:
        """(e, k) at the k points of cells with nodes (e, a, 3), cubic metres."""
        return np.linalg.det(np.einsum("eai,kaj->ekij", nodes, self.gradients, optimize=True))

    def coefficients(self, nodes: FloatArray) -> FloatArray:
        """(e, k) of cells with nodes (e, a, 3), cubic metres."""
        return self.determinants(nodes) @ self.form.T

    def divided(self, coefficients: FloatArray) -> FloatArray:
        """(c e, k) of the parts of cells with coefficients (e, k), one cell after the other."""
        parts = np.einsum("ckl,el->eck", self.division, coefficients, optimize=True)
        return parts.reshape(-1, coefficients.shape[1])

    def form_of_parts(self, depth: int) -> FloatArray:
        """(c^depth k, k) from determinants of a cell to the coefficients of its parts, divided so many times."""
        if depth == 0:
            return self.form
        count = len(self.form)
        parts = self.division @ self.form_of_parts(depth - 1).reshape(-1, 1, count, count)
        return parts.reshape(-1, count)


@cache
def bernstein_form(cell_type: str) -> BernsteinForm:
    """The form of an element: of a product of simplices, it is the product of theirs."""
    element = ELEMENTS[cell_type]
    simplices = [_Simplex(dimension, degree) for dimension, degree in element.jacobian]
    lattice = [np.concatenate(parts) for parts in itertools.product(*(s.lattice[:, 1:] for s in simplices))]
    corners = [all(parts) for parts in itertools.product(*((s.lattice == 1.0).any(axis=1) for s in simplices))]
    division = [_product(parts) for parts in itertools.product(*(s.division for s in simplices))]
    return BernsteinForm(
        gradients=np.ascontiguousarray(element.gradients_at(np.transpose(lattice))),
        form=_product([s.form for s in simplices]),
        division=np.array(division),
        corners=np.flatnonzero(corners),
    )


def _product(factors: Iterable[FloatArray]) -> FloatArray:
    return reduce(lambda left, right: np.asarray(np.kron(left, right), dtype=np.float64), factors)


class _Simplex:
    """Bernstein polynomials of one degree on a simplex; points are barycentric, coefficients in the lattice's order."""

    def __init__(self, dimension: int, degree: int) -> None:
        exponents = itertools.product(range(degree + 1), repeat=dimension + 1)
        self._exponents = np.array([e for e in exponents if sum(e) == degree])
        self._counts = [math.factorial(degree) / math.prod(map(math.factorial, e)) for e in self._exponents]
        self.lattice = self._exponents / degree if degree else np.eye(dimension + 1)[:1]
        self.form: FloatArray = np.linalg.inv(self._values(self.lattice)).astype(np.float64)
        parts = [0.5 * np.eye(dimension + 1)[np.array(part)].sum(axis=1) for part in PARTS[dimension]]
        self.division = [self.form @ self._values(self.lattice @ corners) for corners in parts]

    def _values(self, points: FloatArray) -> FloatArray:
        """(p, k) of the polynomials at points (p, dimension + 1)."""
        return self._counts * np.prod(points[:, None] ** self._exponents, axis=2)
