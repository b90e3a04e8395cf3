"""Bounds of J = det F over whole cells, not only at their quadrature points.

The determinant of the derivatives of a cell's map is a polynomial, and so it lies between the least and the greatest of
its Bernstein coefficients (Johnen, Remacle and Geuzaine 2013). J is the ratio of two such determinants, deformed over
rest, with coefficients b and r: where r > 0, it lies between the least and the greatest of b / r.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cache, reduce

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.discretisation import CellBlock, Discretisation, IntArray
from risorius_offline.elements import ELEMENTS

# Halvings of a cell along its edges before its sign counts as open.
DEEPEST = 7
# By dimension: a simplex divided along the middles of its edges. The corners of a part lie half way between two corners.
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
class JacobianBounds:
    """The smallest J in each cell (e,), block by block, lies between `lower` and `upper`; the latter is a value of J."""

    lower: FloatArray
    upper: FloatArray

    @property
    def positive(self) -> bool:
        """Whether J > 0 everywhere, up to rounding."""
        return bool((self.lower > 0.0).all())


def jacobian_bounds(discretisation: Discretisation, u: FloatArray) -> JacobianBounds:
    """Bounds of the smallest J of every cell at a displacement u (n, 3) in metres.

    A cell is divided until its J is known to be positive, a value of J that is not is found, or `DEEPEST` is reached.
    """
    points = discretisation.points
    bounds = [_block_bounds(block.cells, points, points + u) for block in discretisation.volumes]
    lower, upper = (np.concatenate(part) for part in zip(*bounds, strict=True))
    return JacobianBounds(lower, upper)


def _block_bounds(cells: CellBlock, rest: FloatArray, deformed: FloatArray) -> tuple[FloatArray, FloatArray]:
    polynomial = _bernstein(cells.cell_type)
    r, b = (polynomial.coefficients(points[cells.connectivity]) for points in (rest, deformed))
    lower, upper = np.full(len(r), np.inf), np.full(len(r), np.inf)
    owner = np.arange(len(r))
    for depth in range(DEEPEST + 1):
        at_corners = b[:, polynomial.corners] / r[:, polynomial.corners]
        np.minimum.at(upper, owner, at_corners.min(axis=1))
        least = np.where((r > 0.0).all(axis=1), (b / np.where(r > 0.0, r, 1.0)).min(axis=1), -np.inf)
        open_ = (least <= 0.0) & (upper[owner] > 0.0) & (depth < DEEPEST)
        np.minimum.at(lower, owner[~open_], least[~open_])
        r, b = (polynomial.divided(part[open_]) for part in (r, b))
        owner = np.repeat(owner[open_], len(polynomial.division))
    return lower, upper


@dataclass(frozen=True)
class _Bernstein:
    """Bernstein form of the determinants of an element.

    from_values (k, k) takes values at k points of the reference cell to coefficients; gradients (k, a, 3) of the shape
    functions there. division (c, k, k) takes the coefficients of a cell to those of its c parts. corners: numbers of
    the coefficients that are values at corners.
    """

    from_values: FloatArray
    gradients: FloatArray
    division: FloatArray
    corners: IntArray
    lattice: FloatArray

    def coefficients(self, nodes: FloatArray) -> FloatArray:
        """(e, k) of the determinants of cells with nodes (e, a, 3)."""
        determinants = np.linalg.det(np.einsum("eai,kaj->ekij", nodes, self.gradients, optimize=True))
        return determinants @ self.from_values.T

    def divided(self, coefficients: FloatArray) -> FloatArray:
        """(c e, k) of the parts of every cell, one cell after the other."""
        parts = np.einsum("ckl,el->eck", self.division, coefficients, optimize=True)
        return parts.reshape(-1, coefficients.shape[1])


@cache
def _bernstein(cell_type: str) -> _Bernstein:
    element = ELEMENTS[cell_type]
    simplices = [_Simplex(dimension, degree) for dimension, degree in element.jacobian]
    lattice = [np.concatenate(parts) for parts in itertools.product(*(s.lattice[:, 1:] for s in simplices))]
    corners = [all(parts) for parts in itertools.product(*((s.lattice == 1.0).any(axis=1) for s in simplices))]
    division = [reduce(np.kron, parts) for parts in itertools.product(*(s.division for s in simplices))]
    return _Bernstein(
        from_values=reduce(np.kron, [s.from_values for s in simplices]),
        gradients=element.gradients_at(np.transpose(lattice)),
        division=np.array(division),
        corners=np.flatnonzero(corners),
        lattice=np.array(lattice),
    )


class _Simplex:
    """Bernstein polynomials of one degree on a simplex; points are barycentric, coefficients in the lattice's order."""

    def __init__(self, dimension: int, degree: int) -> None:
        exponents = itertools.product(range(degree + 1), repeat=dimension + 1)
        self._exponents = np.array([e for e in exponents if sum(e) == degree])
        self._counts = [math.factorial(degree) / math.prod(map(math.factorial, e)) for e in self._exponents]
        self.lattice = self._exponents / degree
        self.from_values = np.linalg.inv(self._values(self.lattice))
        parts = [0.5 * np.eye(dimension + 1)[np.array(part)].sum(axis=1) for part in PARTS[dimension]]
        self.division = [self.from_values @ self._values(self.lattice @ corners) for corners in parts]

    def _values(self, points: FloatArray) -> FloatArray:
        """(p, k) of the polynomials at points (p, dimension + 1)."""
        return self._counts * np.prod(points[:, None] ** self._exponents, axis=2)
