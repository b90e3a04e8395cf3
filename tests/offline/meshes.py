"""Small meshes for tests: boxes of every element type, slightly distorted."""

from __future__ import annotations

import itertools

import numpy as np

from risorius_offline.discretisation import CellBlock

HEX_CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])


def box_hexahedra(cells: tuple[int, int, int], size: tuple[float, float, float]):
    """Nodes (n, 3) of a box from the origin, in lexicographic order, and its hexahedra (e, 8)."""
    axes = [np.linspace(0.0, length, count + 1) for length, count in zip(size, cells, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    shape = np.array(cells) + 1
    first = np.stack(np.meshgrid(*[np.arange(c) for c in cells], indexing="ij"), axis=-1).reshape(-1, 1, 3)
    return points, np.ravel_multi_index(np.moveaxis(first + HEX_CORNERS, -1, 0), shape)


def kuhn_tetrahedra(hexahedra):
    """Six tetrahedra (6 e, 4) for every hexahedron, one per order of the axes."""
    corner = {tuple(c): i for i, c in enumerate(HEX_CORNERS)}
    result = []
    for order in itertools.permutations(range(3)):
        steps = np.cumsum([np.zeros(3, int), *np.eye(3, dtype=int)[list(order)]], axis=0)
        tet = [corner[tuple(step)] for step in steps]
        if np.linalg.det(steps[1:] - steps[0]) < 0:
            tet = [tet[0], tet[2], tet[1], tet[3]]
        result.append(hexahedra[:, tet])
    return np.stack(result, axis=1).reshape(-1, 4)


def wedges(hexahedra):
    """Two wedges (2 e, 6) for every hexahedron."""
    halves = [hexahedra[:, [0, 1, 2, 4, 5, 6]], hexahedra[:, [0, 2, 3, 4, 6, 7]]]
    return np.stack(halves, axis=1).reshape(-1, 6)


def with_midpoints(points, tetrahedra):
    """Quadratic tetrahedra (e, 10) and all their nodes."""
    edges = np.array([(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)])
    pairs = np.sort(tetrahedra[:, edges].reshape(-1, 2), axis=1)
    unique, number = np.unique(pairs, axis=0, return_inverse=True)
    middle = points[unique].mean(axis=1)
    return np.concatenate([points, middle]), np.hstack([tetrahedra, len(points) + number.reshape(-1, 6)])


def box(cell_type: str, cells=(2, 2, 2), size=(0.02, 0.02, 0.02), distortion=0.0):
    """Nodes and one block of cells of a type; inner vertices are moved by `distortion` of a cell."""
    points, hexahedra = box_hexahedra(cells, size)
    inner = ((points > 1e-9) & (points < np.array(size) - 1e-9)).all(axis=1)
    shift = np.random.default_rng(1).uniform(-1.0, 1.0, points.shape) * np.array(size) / np.array(cells)
    points[inner] += distortion * shift[inner]
    connectivity = {
        "hexahedron": lambda: hexahedra,
        "wedge": lambda: wedges(hexahedra),
        "tetra": lambda: kuhn_tetrahedra(hexahedra),
        "tetra10": lambda: kuhn_tetrahedra(hexahedra),
    }[cell_type]()
    if cell_type == "tetra10":
        points, connectivity = with_midpoints(points, connectivity)
    return points, CellBlock(cell_type, connectivity, np.zeros(len(connectivity), dtype=np.int64))


def mirrored(points, cells: CellBlock):
    """A mesh in x >= 0 and its mirror image in the plane x = 0, joined there: nodes, cells and each node's partner."""
    nodes = [tuple(node) for node in cells.element.nodes]
    # Every reference cell is symmetric in its first two axes: numbering the image with them swapped keeps its volume.
    swapped = [nodes.index((y, x, z)) for x, y, z in nodes]
    off_plane = np.flatnonzero(points[:, 0] > 1e-12)
    image = np.arange(len(points))
    image[off_plane] = len(points) + np.arange(len(off_plane))
    both = np.concatenate([points, points[off_plane] * [-1.0, 1.0, 1.0]])
    partner = np.concatenate([image, off_plane])
    connectivity = np.concatenate([cells.connectivity, image[cells.connectivity[:, swapped]]])
    return both, CellBlock(cells.cell_type, connectivity, np.tile(cells.layer, 2)), partner
