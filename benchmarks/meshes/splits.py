"""The same nodes in other elements: hexahedra and wedges cut into tetrahedra, hexahedra into wedges."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from risorius.errors import SolverError
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.discretisation import CellBlock

ROUNDS = 400


def tetrahedral(anatomy: Anatomy) -> Anatomy:
    """Every cell as a cone from its first node over its other faces, quadrilaterals cut from their first node.

    Neighbours agree on the diagonal of a face, since both cut it from the same node (Dompierre et al. 1999). First is
    the smallest number; where that turns a tetrahedron of a skewed cell inside out, a random node of the cell becomes
    first of all, until none is left.
    """
    rank = np.arange(len(anatomy.points))
    random = np.random.default_rng(0)
    for round_number in range(ROUNDS):
        tetrahedra, layers, owners = _cones(anatomy, rank)
        inverted = np.unique(owners[_volumes(anatomy.points, tetrahedra) <= 0.0], axis=0)
        if not len(inverted):
            cells = (CellBlock("tetra", tetrahedra, layers),)
            return replace(anatomy, cells=cells, skin=np.zeros((0, 3), dtype=np.int64), epidermis=0.0)
        for block, cell in inverted:
            rank[random.choice(anatomy.cells[block].connectivity[cell])] = -round_number - 1
    raise SolverError(f"{len(inverted)} cells of {anatomy.name!r} have no split into upright tetrahedra")


def _cones(anatomy: Anatomy, rank: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Tetrahedra (t, 4), their layer (t,), and block and cell (t, 2) that each is cut from."""
    tetrahedra, layers, owners = [], [], []
    for number, block in enumerate(anatomy.cells):
        apex = rank[block.connectivity].argmin(axis=1)
        for corner in range(block.element.corners):
            cells = np.flatnonzero(apex == corner)
            mine = block.connectivity[cells]
            for face in (face for face in block.element.faces if corner not in face):
                for triangle in _triangles(mine[:, face], rank):
                    tetrahedra.append(np.column_stack([triangle[:, [0, 2, 1]], mine[:, corner]]))
                    layers.append(block.layer[cells])
                    owners.append(np.column_stack([np.full(len(cells), number), cells]))
    return np.concatenate(tetrahedra), np.concatenate(layers), np.concatenate(owners)


def _triangles(faces: np.ndarray, rank: np.ndarray) -> list[np.ndarray]:
    """Triangles (k, 3) of faces (k, 3) or (k, 4), the latter cut from their first node."""
    if faces.shape[1] == 3:
        return [faces]
    turned = (rank[faces].argmin(axis=1)[:, None] + np.arange(4)) % 4
    faces = np.take_along_axis(faces, turned, axis=1)
    return [faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]]


def _volumes(points: np.ndarray, tetrahedra: np.ndarray) -> np.ndarray:
    origin, *others = np.moveaxis(points[tetrahedra], 1, 0)
    return np.linalg.det(np.stack([other - origin for other in others], axis=1)) / 6.0


def wedged(anatomy: Anatomy) -> Anatomy:
    """Every hexahedron as two wedges along its third axis; neighbours must be numbered alike, as in a box."""
    (block,) = anatomy.cells
    halves = [block.connectivity[:, [0, 1, 2, 4, 5, 6]], block.connectivity[:, [0, 2, 3, 4, 6, 7]]]
    cells = (CellBlock("wedge", np.concatenate(halves), np.tile(block.layer, 2)),)
    return replace(anatomy, cells=cells, skin=np.zeros((0, 3), dtype=np.int64), epidermis=0.0)
