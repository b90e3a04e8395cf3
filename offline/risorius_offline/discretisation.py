"""A mesh with its integration tables: gradients, weights and the pattern of the sparse tangent."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.elements import ELEMENTS, ReferenceElement

IntArray: TypeAlias = npt.NDArray[np.int64]


@dataclass(frozen=True)
class CellBlock:
    """Cells of one type: meshio's type name, connectivity (e, a) in VTK order and the layer (e,) of every cell."""

    cell_type: str
    connectivity: IntArray
    layer: IntArray

    @property
    def element(self) -> ReferenceElement:
        """The reference element of the cells."""
        return ELEMENTS[self.cell_type]


@dataclass(frozen=True)
class IntegratedBlock:
    """A block with shape function gradients (e, q, a, 3), point volumes (e, q) and point positions (e, q, 3)."""

    cells: CellBlock
    gradients: FloatArray
    weights: FloatArray
    positions: FloatArray

    @classmethod
    def of(cls, points: FloatArray, cells: CellBlock) -> IntegratedBlock:
        """Integrate a block of cells over node positions (n, 3); raises InputError for inverted cells."""
        element = cells.element
        corners = points[cells.connectivity]
        jacobian = np.einsum("eai,qaj->eqij", corners, element.reference_gradients)
        determinant = np.linalg.det(jacobian)
        bad = np.flatnonzero(determinant.min(axis=1) <= 0.0)
        if len(bad):
            raise InputError(
                f"{len(bad)} {cells.cell_type} cell(s) are inverted or flat, first cell {bad[0]} with nodes "
                f"{cells.connectivity[bad[0]].tolist()}; give the nodes in VTK order with positive volume"
            )
        gradients = np.einsum("qaj,eqji->eqai", element.reference_gradients, np.linalg.inv(jacobian))
        return cls(
            cells=cells,
            gradients=np.ascontiguousarray(gradients),
            weights=np.ascontiguousarray(determinant * element.weights),
            positions=np.einsum("qa,eai->eqi", element.shape_functions(element.points), corners),
        )

    def deformation_gradients(self, u: FloatArray) -> FloatArray:
        """F (e, q, 3, 3) at the points, for a displacement u (n, 3) in metres."""
        return np.eye(3) + np.einsum("eai,eqaj->eqij", u[self.cells.connectivity], self.gradients, optimize=True)

    def mean_jacobians(self, u: FloatArray) -> FloatArray:
        """Jbar (e,): the mean of J = det F over the volume at rest of every cell."""
        jacobians = np.linalg.det(self.deformation_gradients(u))
        return (self.weights * jacobians).sum(axis=1) / self.weights.sum(axis=1)


def triangle_owners(cells: CellBlock, triangles: IntArray) -> list[tuple[int, int, tuple[int, ...]]]:
    """Triangle, cell and the triangle's corners in the cell, for those triangles (m, 3) that are part of a cell's face.

    In the order of the triangles.
    """
    wanted = {tuple(sorted(triangle)): number for number, triangle in enumerate(triangles.tolist())}
    owners: list[tuple[int, int, tuple[int, ...]]] = []
    for corners in {c for face in cells.element.faces for c in itertools.combinations(face, 3)}:
        keys = np.sort(cells.connectivity[:, corners], axis=1).tolist()
        owners += [(wanted[k], e, corners) for e, k in enumerate(map(tuple, keys)) if k in wanted]
    return sorted(owners)


def film(points: FloatArray, cells: CellBlock, triangles: IntArray, thickness: float) -> IntegratedBlock:
    """A film of `thickness` metres on those surface triangles (m, 3) that are part of a face of the cells.

    Every triangle is integrated at its centroid, with the deformation of the cell behind it: in the order of
    `triangle_owners`.
    """
    element = cells.element
    owners = triangle_owners(cells, triangles)
    rows = np.array([e for _, e, _ in owners], dtype=np.int64)
    centroids = np.array([np.asarray(element.nodes)[list(c)].mean(axis=0) for _, _, c in owners]).reshape(-1, 3)
    reference = element.gradients_at(centroids.T)
    jacobian = np.einsum("eai,eaj->eij", points[cells.connectivity[rows]], reference)
    x = points[triangles[[number for number, _, _ in owners]]]
    area = 0.5 * np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1)
    return IntegratedBlock(
        cells=CellBlock(cells.cell_type, cells.connectivity[rows], cells.layer[rows]),
        gradients=np.ascontiguousarray(np.einsum("eaj,eji->eai", reference, np.linalg.inv(jacobian))[:, None]),
        weights=np.ascontiguousarray(thickness * area[:, None]),
        positions=x.mean(axis=1)[:, None],
    )


class Discretisation:
    """Integration tables of a mesh: volume blocks and, where there is an epidermis, film blocks on the skin.

    points (n, 3) in metres; one sparse pattern, the upper triangle, for all blocks.
    """

    def __init__(
        self, points: FloatArray, cells: Sequence[CellBlock], skin: IntArray | None = None, epidermis: float = 0.0
    ) -> None:
        self.points = np.ascontiguousarray(points, dtype=np.float64)
        self.volumes = tuple(IntegratedBlock.of(self.points, block) for block in cells)
        self.films: tuple[IntegratedBlock, ...] = ()
        if epidermis > 0.0 and skin is not None:
            self.films = tuple(film(self.points, block, skin, epidermis) for block in cells)
        self.blocks = self.volumes + self.films

    @property
    def dof_count(self) -> int:
        """Number of displacement components, free and prescribed."""
        return self.points.size

    @cached_property
    def pattern(self) -> sp.csr_matrix:
        """Upper triangle (rows <= columns) of the tangent over all components, with zero entries."""
        # A node's neighbours, itself the first, have three columns each; its row i lacks the first i of all these.
        lengths = np.diff(self._row_starts)
        columns = (3 * (self._pairs % len(self.points))[:, None] + np.arange(3)).ravel()
        row, component = np.divmod(np.arange(self.dof_count), 3)
        first = 3 * self._pair_starts[row] + component
        places = np.arange(self._row_starts[-1]) + np.repeat(first - self._row_starts[:-1], lengths)
        shape = (self.dof_count, self.dof_count)
        return sp.csr_matrix((np.zeros(len(places)), columns[places], self._row_starts), shape=shape)

    @cached_property
    def scatter(self) -> tuple[npt.NDArray[np.int32], ...]:
        """Per block (e, 3 a, 3 a): position in the pattern's data of every entry, -1 below the diagonal."""
        return tuple(self._positions(block.cells.connectivity) for block in self.blocks)

    def _positions(self, connectivity: IntArray) -> npt.NDArray[np.int32]:
        dofs, component = _dofs(connectivity), np.tile(np.arange(3), connectivity.shape[1])
        rows, columns = connectivity[:, :, None], connectivity[:, None, :]
        neighbours = np.searchsorted(self._pairs, rows * len(self.points) + columns) - self._pair_starts[rows]
        positions = 3 * np.repeat(np.repeat(neighbours, 3, axis=1), 3, axis=2)
        positions += (self._row_starts[dofs] - component)[:, :, None] + component
        positions[dofs[:, :, None] > dofs[:, None, :]] = -1
        return positions.astype(np.int32)

    @cached_property
    def _pairs(self) -> IntArray:
        """Sorted keys A n + B of the nodes A <= B that share a cell."""
        keys = []
        for block in self.blocks:
            a, b = block.cells.connectivity[:, :, None], block.cells.connectivity[:, None, :]
            keys.append((a * len(self.points) + b)[a <= b])
        return np.unique(np.concatenate(keys))

    @cached_property
    def _pair_starts(self) -> IntArray:
        """(n + 1,) where the keys of a node begin."""
        return np.searchsorted(self._pairs, np.arange(len(self.points) + 1) * len(self.points))

    @cached_property
    def _row_starts(self) -> IntArray:
        """(3 n + 1,) where the rows of the pattern begin."""
        lengths = np.maximum(3 * np.diff(self._pair_starts)[:, None] - np.arange(3), 0).ravel()
        return np.concatenate([[0], np.cumsum(lengths)])

    @cached_property
    def nodal_volumes(self) -> FloatArray:
        """(n,) lumped volume of every node, cubic metres: the diagonal of the mass matrix, scaled to the element's
        volume (Hinton, Rock and Zienkiewicz 1976), which stays positive on quadratic elements.
        """
        volumes = np.zeros(len(self.points))
        for block in self.volumes:
            diagonal = block.weights @ block.cells.element.shape_functions(block.cells.element.points) ** 2
            scale = block.weights.sum(axis=1) / diagonal.sum(axis=1)
            np.add.at(volumes, block.cells.connectivity, diagonal * scale[:, None])
        return volumes

    @cached_property
    def consistent_volumes(self) -> FloatArray:
        """(n,) integral of every node's shape function, cubic metres: the nodal forces of a unit force density."""
        volumes = np.zeros(len(self.points))
        for block in self.volumes:
            shares = block.weights @ block.cells.element.shape_functions(block.cells.element.points)
            np.add.at(volumes, block.cells.connectivity, shares)
        return volumes


def _dofs(connectivity: IntArray) -> IntArray:
    """(e, 3 a) component numbers, node by node."""
    return (3 * connectivity[:, :, None] + np.arange(3)).reshape(len(connectivity), -1)
