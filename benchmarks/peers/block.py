"""The problem that all codes solve: a soft block, held below, whose top is dragged sideways in equal load steps.

Compressible neo-Hookean, W = mu/2 (I1 - 3) - mu ln J + lam/2 (ln J)^2, trilinear hexahedra, 2 x 2 x 2 points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

YOUNG, POISSON = 15e3, 0.45
SIZE = (0.06, 0.06, 0.012)
DRAG = 0.008
CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])


@dataclass(frozen=True)
class Block:
    """points (n, 3) in metres, hexahedra (e, 8) in VTK order, held and dragged (n,) flags, displacement per step."""

    points: np.ndarray
    hexahedra: np.ndarray
    held: np.ndarray
    dragged: np.ndarray
    steps: int

    @classmethod
    def of(cls, cells: tuple[int, int, int], steps: int) -> Block:
        """Block of so many cells along x, y and z."""
        axes = [np.linspace(0.0, length, count + 1) for length, count in zip(SIZE, cells, strict=True)]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        first = np.stack(np.meshgrid(*[np.arange(c) for c in cells], indexing="ij"), axis=-1).reshape(-1, 1, 3)
        hexahedra = np.ravel_multi_index(np.moveaxis(first + CORNERS, -1, 0), np.array(cells) + 1)
        middle = (np.abs(points[:, :2] - 0.5 * np.array(SIZE[:2])) <= 0.0101).all(axis=1)
        top = np.isclose(points[:, 2], SIZE[2])
        return cls(points, hexahedra, np.isclose(points[:, 2], 0.0), top & middle, steps)

    @property
    def lame(self) -> tuple[float, float]:
        """Shear modulus and first Lame parameter, pascals."""
        return YOUNG / (2 * (1 + POISSON)), YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
