"""What an element type is: nodes, basis, quadrature and faces on the reference cell."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import skfem
from skfem.quadrature import get_quadrature
from skfem.refdom import RefLine, RefTri, RefWedge

from risorius.jaw import FloatArray


@dataclass(frozen=True)
class ReferenceElement:
    """An element in VTK node order with positive volume.

    nodes: (a, 3) reference coordinates. points (3, q) and weights (q,): quadrature. corners: number of vertices.
    mass_rule: points and weights that integrate products of two shape functions exactly on an undistorted cell.
    faces: vertices of each face, counter-clockwise seen from outside. basis: the scikit-fem element whose shape
    functions are used; its own node order does not matter.
    jacobian: the simplices whose product the reference cell is, in the order of its axes: the dimension of each, and
    the degree along it of the determinant of the derivatives of a map of the cell.
    """

    cell_type: str
    nodes: tuple[tuple[float, float, float], ...]
    basis: skfem.Element
    points: FloatArray
    weights: FloatArray
    mass_rule: tuple[FloatArray, FloatArray]
    corners: int
    faces: tuple[tuple[int, ...], ...]
    jacobian: tuple[tuple[int, int], ...]

    @property
    def jacobian_is_constant(self) -> bool:
        """Whether J is the same everywhere in a cell."""
        return all(degree == 0 for _, degree in self.jacobian)

    @cached_property
    def reference_gradients(self) -> FloatArray:
        """(q, a, 3) derivatives of the shape functions at the quadrature points, in VTK node order."""
        return self.gradients_at(self.points)

    def gradients_at(self, points: FloatArray) -> FloatArray:
        """(q, a, 3) derivatives of the shape functions at reference points (3, q), in VTK node order."""
        return np.stack([self.basis.lbasis(points, i)[1].T for i in self._order], axis=1)

    def shape_functions(self, points: FloatArray) -> FloatArray:
        """(q, a) shape functions at reference points (3, q), in VTK node order."""
        return np.stack([self.basis.lbasis(points, i)[0] * np.ones(points.shape[1]) for i in self._order], axis=1)

    @cached_property
    def _order(self) -> list[int]:
        locations = np.asarray(self.basis.doflocs)
        return [int(np.abs(locations - node).sum(axis=1).argmin()) for node in np.asarray(self.nodes)]


def gauss(basis: skfem.Element, order: int) -> tuple[FloatArray, FloatArray]:
    """Points (3, q) and weights (q,) of a rule that is exact for polynomials of an order.

    A wedge gets scikit-fem's triangle rule times its line rule: the weights of scikit-fem 12's own rule for wedges sum
    to half of the reference volume.
    """
    if basis.refdom is not RefWedge:
        return get_quadrature(basis.refdom, order)
    (triangle, triangle_weights), (line, line_weights) = (get_quadrature(r, order) for r in (RefTri, RefLine))
    points = np.vstack([np.repeat(triangle, line.shape[1], axis=1), np.tile(line, triangle.shape[1])])
    return points, np.outer(triangle_weights, line_weights).ravel()
