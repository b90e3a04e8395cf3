"""Second derivatives of an energy at one state, with as much of their projection as a factorisation takes."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

from risorius.jaw import FloatArray
from risorius_offline.effects.effect import NodeBlocks


class Projection(NamedTuple):
    """Whether obstacles are projected, and the share of the projection of tissue: a mixture with the true derivatives.

    Obstacles are walls and what effects add, contact above all: little of the whole, but often all that is not convex.
    """

    obstacles: bool
    share: float


TRUE, PROJECTED = Projection(False, 0.0), Projection(True, 1.0)


class Tangents:
    """The tangent at one state in all projections; each of its parts is computed once, when it is first asked for.

    of_obstacles and of_tissue take whether to project: values (nnz,) in a pattern, for obstacles with blocks besides.
    """

    def __init__(
        self,
        of_obstacles: Callable[[bool], tuple[FloatArray, list[NodeBlocks]]],
        of_tissue: Callable[[bool], FloatArray],
    ) -> None:
        self._of_obstacles, self._of_tissue = cache(of_obstacles), cache(of_tissue)

    @property
    def at_obstacles(self) -> bool:
        """Whether any cell is at its wall, or any effect has second derivatives."""
        values, blocks = self._of_obstacles(False)
        return bool(values.any()) or any(len(block.nodes) > 0 for block in blocks)

    def mixed(self, projection: Projection) -> tuple[FloatArray, list[NodeBlocks]]:
        """Values (nnz,) in the pattern and node blocks."""
        obstacles, blocks = self._of_obstacles(projection.obstacles)
        values = obstacles.copy()
        for share, project in ((1.0 - projection.share, False), (projection.share, True)):
            if share > 0.0:
                values += share * self._of_tissue(project)
        return values, blocks
