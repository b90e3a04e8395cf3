"""The problem that all codes solve: a soft block, held below, whose top is dragged sideways in equal load steps.

Compressible neo-Hookean, W = mu/2 (I1 - 3) - mu ln J + lam/2 (ln J)^2. Trilinear hexahedra with 2 x 2 x 2 points, or
quadratic tetrahedra with four.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

POISSON = 0.45
SIZE = (0.06, 0.06, 0.012)
DRAG = 0.008
STEPS = 4
TOLERANCE = 1e-8  # norm of the free forces relative to that of the reactions

CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
EDGES = np.array([(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)])


@dataclass(frozen=True)
class Block:
    """points (n, 3) in metres, connectivity (e, a) in VTK order, layer (e,), held and dragged (n,) flags.

    young: modulus (Pa) of every layer, from below.
    """

    cell_type: str
    points: np.ndarray
    connectivity: np.ndarray
    layer: np.ndarray
    young: tuple[float, ...]
    held: np.ndarray
    dragged: np.ndarray

    @classmethod
    def of_hexahedra(cls, cells: tuple[int, int, int], young: tuple[float, ...] = (15e3,)) -> Block:
        """Block of so many hexahedra along x, y and z, in layers of equal thickness."""
        return cls._of("hexahedron", np.array(cells), CORNERS[None], young)

    @classmethod
    def of_tetrahedra(cls, cells: tuple[int, int, int], young: tuple[float, ...] = (15e3,)) -> Block:
        """Block of so many boxes along x, y and z, each of six quadratic tetrahedra."""
        corners = np.array([_tetrahedron(order) for order in itertools.permutations(range(3))])
        nodes = np.concatenate([2 * corners, corners[:, EDGES].sum(axis=2)], axis=1)
        return cls._of("tetra10", np.array(cells), nodes, young)

    @classmethod
    def _of(cls, cell_type: str, cells: np.ndarray, nodes: np.ndarray, young: tuple[float, ...]) -> Block:
        """nodes (k, a, 3): places of the nodes of the k cells that fill a box, in steps of the lattice of all nodes."""
        pitch = nodes.max()
        lattice = pitch * cells
        axes = [np.linspace(0.0, length, count + 1) for length, count in zip(SIZE, lattice, strict=True)]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        boxes = np.stack(np.meshgrid(*[np.arange(count) for count in cells], indexing="ij"), axis=-1).reshape(-1, 3)
        places = (pitch * boxes[:, None, None] + nodes).reshape(-1, *nodes.shape[1:])
        middle = (np.abs(points[:, :2] - 0.5 * np.array(SIZE[:2])) <= 0.0101).all(axis=1)
        return cls(
            cell_type=cell_type,
            points=points,
            connectivity=np.ravel_multi_index(np.moveaxis(places, -1, 0), lattice + 1),
            layer=np.repeat(boxes[:, 2] * len(young) // cells[2], len(nodes)),
            young=young,
            held=np.isclose(points[:, 2], 0.0),
            dragged=np.isclose(points[:, 2], SIZE[2]) & middle,
        )


@dataclass(frozen=True)
class Solution:
    """Displacement (n, 3), and the iterations and factorisations of all load steps."""

    u: np.ndarray
    iterations: int
    factorisations: int


def lame(young: float) -> tuple[float, float]:
    """Shear modulus and first Lame parameter, pascals."""
    return young / (2 * (1 + POISSON)), young * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))


def _tetrahedron(order: tuple[int, ...]) -> np.ndarray:
    """Corners (4, 3) of the tetrahedron of a unit cube whose path along its edges takes the axes in order."""
    corners = np.cumsum([np.zeros(3, dtype=int), *np.eye(3, dtype=int)[list(order)]], axis=0)
    return corners if np.linalg.det(corners[1:]) > 0 else corners[[0, 2, 1, 3]]
