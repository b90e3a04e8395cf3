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
        rows, columns = [], []
        for block in self.blocks:
            dofs = _dofs(block.cells.connectivity)
            upper = np.broadcast_to(dofs[:, :, None] <= dofs[:, None, :], (*dofs.shape, dofs.shape[1]))
            rows.append(np.broadcast_to(dofs[:, :, None], upper.shape)[upper])
            columns.append(np.broadcast_to(dofs[:, None, :], upper.shape)[upper])
        row, column = np.concatenate(rows), np.concatenate(columns)
        matrix = sp.csr_matrix((np.zeros(len(row)), (row, column)), shape=(self.dof_count, self.dof_count))
        matrix.sort_indices()
        return matrix

    @cached_property
    def scatter(self) -> tuple[npt.NDArray[np.int32], ...]:
        """Per block (e, 3 a, 3 a): position in the pattern's data of every entry, -1 below the diagonal."""
        key = self._keys(np.repeat(np.arange(self.dof_count), np.diff(self.pattern.indptr)), self.pattern.indices)
        tables = []
        for block in self.blocks:
            dofs = _dofs(block.cells.connectivity)
            wanted = self._keys(dofs[:, :, None], dofs[:, None, :])
            position = np.searchsorted(key, wanted).astype(np.int32)
            position[dofs[:, :, None] > dofs[:, None, :]] = -1
            tables.append(position)
        return tuple(tables)

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

    def _keys(self, rows: npt.ArrayLike, columns: npt.ArrayLike) -> IntArray:
        return np.asarray(rows, dtype=np.int64) * self.dof_count + np.asarray(columns, dtype=np.int64)


def _dofs(connectivity: IntArray) -> IntArray:
    """(e, 3 a) component numbers, node by node."""
    return (3 * connectivity[:, :, None] + np.arange(3)).reshape(len(connectivity), -1)
