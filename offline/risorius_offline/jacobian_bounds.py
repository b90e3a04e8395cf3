"""Bounds of J = det F over whole cells, not only at their quadrature points.

J is the ratio of two determinants, deformed over rest, with Bernstein coefficients b and r: where r > 0, it lies
between the least and the greatest of b / r.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.bernstein import bernstein_form
from risorius_offline.discretisation import CellBlock, Discretisation

# Halvings of a cell along its edges before its sign counts as open.
DEEPEST = 7


@dataclass(frozen=True)
class JacobianBounds:
    """The smallest J in each cell (e,), block by block, is at least `lower` and at most `upper`, a value of J there."""

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
    bernstein = bernstein_form(cells.cell_type)
    r, b = (bernstein.coefficients(points[cells.connectivity]) for points in (rest, deformed))
    lower, upper = np.full(len(r), np.inf), np.full(len(r), np.inf)
    owner = np.arange(len(r))
    for depth in range(DEEPEST + 1):
        at_corners = b[:, bernstein.corners] / r[:, bernstein.corners]
        np.minimum.at(upper, owner, at_corners.min(axis=1))
        least = np.where((r > 0.0).all(axis=1), (b / np.where(r > 0.0, r, 1.0)).min(axis=1), -np.inf)
        open_ = (least <= 0.0) & (upper[owner] > 0.0) & (depth < DEEPEST)
        np.minimum.at(lower, owner[~open_], least[~open_])
        r, b = (bernstein.divided(part[open_]) for part in (r, b))
        owner = np.repeat(owner[open_], len(bernstein.division))
    return lower, upper
