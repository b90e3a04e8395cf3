"""Second derivatives of an energy at one state, with as much of their projection as a factorisation takes."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

from risorius.jaw import FloatArray
from risorius_offline.effects.effect import NodeBlocks


class Projection(NamedTuple):
    """Whether walls are projected, and the share of the projection of all else: a mixture with the true derivatives."""

    walls: bool
    share: float


TRUE, PROJECTED = Projection(False, 0.0), Projection(True, 1.0)


class Tangents:
    """The tangent at one state in all projections; each of its parts is computed once, when it is first asked for.

    of_walls and of_others take whether to project: values (nnz,) in a pattern, for all but walls with blocks besides.
    """

    def __init__(
        self,
        of_walls: Callable[[bool], FloatArray],
        of_others: Callable[[bool], tuple[FloatArray, list[NodeBlocks]]],
    ) -> None:
        self._of_walls, self._of_others = cache(of_walls), cache(of_others)

    @property
    def at_walls(self) -> bool:
        """Whether any cell is at its wall."""
        return bool(self._of_walls(False).any())

    def mixed(self, projection: Projection) -> tuple[FloatArray, list[NodeBlocks]]:
        """Values (nnz,) in the pattern and node blocks."""
        values, blocks = self._of_walls(projection.walls).copy(), []
        for share, project in ((1.0 - projection.share, False), (projection.share, True)):
            if share == 0.0:
                continue
            others, beside = self._of_others(project)
            values += share * others
            blocks += [NodeBlocks(block.nodes, share * block.matrices) for block in beside]
        return values, blocks
