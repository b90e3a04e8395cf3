"""Finer meshes of the same geometry: every hexahedron and wedge into eight, nodes of a cell's edges for tetrahedra.

New nodes are means of old ones, so that every refinement contains the nodes of what it came from, in front.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.discretisation import CellBlock
from risorius_offline.elements import ELEMENTS

PARENTS = 8  # most nodes that a new one is the mean of


def _lattice(cell_type: str) -> tuple[np.ndarray, np.ndarray]:
    """Parents (k, 8) of the nodes of a cell cut in half along every edge, -1 where fewer, and its children (8, a)."""
    nodes = np.array(ELEMENTS[cell_type].nodes)
    doubled = nodes[:, None] + nodes[None]  # twice the middle of every pair of nodes
    if cell_type == "hexahedron":
        children = np.array([nodes + np.array(start) for start in itertools.product((0, 1), repeat=3)])
    else:
        middle = np.array([(1, 1, 0), (0, 1, 0), (1, 0, 0), (1, 1, 1), (0, 1, 1), (1, 0, 1)])
        lower = [*(nodes + np.array(start) for start in ((0, 0, 0), (1, 0, 0), (0, 1, 0))), middle]
        children = np.array([child + np.array((0, 0, level)) for child in lower for level in (0, 1)])
    lattice, number = np.unique(children.reshape(-1, 3), axis=0, return_inverse=True)
    parents = np.full((len(lattice), PARENTS), -1)
    for row, place in zip(parents, lattice, strict=True):
        pairs = np.argwhere((doubled == place).all(axis=2))
        found = np.unique(pairs)
        row[: len(found)] = found
    return parents, number.reshape(len(children), -1)


def refined(anatomy: Anatomy) -> Anatomy:
    """Every hexahedron and wedge cut into eight.

    A new node is held by a bone when all its parents are. The skin is left out: no element needs it.
    """
    rows, blocks = [], []
    for block in anatomy.cells:
        parents, children = _lattice(block.cell_type)
        padded = np.concatenate([block.connectivity, np.full((len(block.connectivity), 1), -1)], axis=1)
        rows.append(np.sort(padded[:, parents], axis=2))
        blocks.append((block, children))
    prolongation, numbers = _prolongation([r.reshape(-1, PARENTS) for r in rows], len(anatomy.points))
    cells = tuple(
        CellBlock(block.cell_type, number.reshape(len(block.layer), -1)[:, children].reshape(-1, children.shape[1]),
                  np.repeat(block.layer, len(children)))
        for (block, children), number in zip(blocks, numbers, strict=True)
    )  # fmt: skip
    return _on_nodes(anatomy, prolongation, cells)


def with_edge_nodes(anatomy: Anatomy) -> Anatomy:
    """Linear tetrahedra made quadratic with straight edges."""
    (block,) = anatomy.cells
    nodes = np.array(ELEMENTS["tetra10"].nodes)
    edges = np.array([np.argwhere((nodes[:4, None] + nodes[None, :4] == 2 * node).all(axis=2))[0] for node in nodes])
    pairs = np.full((len(block.connectivity), 10, PARENTS), -1)
    pairs[:, :, -2:] = np.sort(block.connectivity[:, edges], axis=2)
    pairs[:, :4, -2] = -1
    prolongation, (number,) = _prolongation([pairs.reshape(-1, PARENTS)], len(anatomy.points))
    cells = (CellBlock("tetra10", number.reshape(-1, 10), block.layer),)
    return _on_nodes(anatomy, prolongation, cells)


def _on_nodes(anatomy: Anatomy, prolongation: sp.csr_matrix, cells: tuple[CellBlock, ...]) -> Anatomy:
    """An anatomy on other nodes and cells, without skin."""
    held = {name: prolongation @ getattr(anatomy, name).astype(float) > 1.0 - 1e-9 for name in ("skull", "jaw")}
    empty = np.zeros((0, 3), dtype=np.int64)
    return replace(anatomy, points=prolongation @ anatomy.points, cells=cells, skin=empty, epidermis=0.0, **held)


def _prolongation(rows: list[np.ndarray], count: int) -> tuple[sp.csr_matrix, list[np.ndarray]]:
    """Means over sorted parents (k, 8), old nodes first; and for each array of rows the number of its new nodes."""
    old = np.full((count, PARENTS), -1)
    old[:, -1] = np.arange(count)
    unique, first, number = np.unique(np.concatenate([old, *rows]), axis=0, return_index=True, return_inverse=True)
    rank = np.empty(len(unique), dtype=np.int64)
    rank[np.argsort(first, kind="stable")] = np.arange(len(unique))
    parents = unique[np.argsort(first, kind="stable")]
    known = parents >= 0
    weights = known / known.sum(axis=1, keepdims=True)
    new, place = np.nonzero(known)
    matrix = sp.csr_matrix((weights[new, place], (new, parents[new, place])), shape=(len(parents), count))
    split = np.cumsum([len(r) for r in rows])[:-1]
    return matrix, np.split(rank[number.ravel()[count:]], split)
