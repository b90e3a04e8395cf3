"""Hard solves of the full model, where the offline part is installed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.metadata import entry_points
from typing import TypeAlias

from risorius.errors import MissingExtraError
from risorius.gauntlet.run import FAILED, PASSED, Result

ENTRY_POINT = "risorius.hard_solves"
GROUP = "full model"
TOLERANCE = 1e-6  # of the residual, relative to muscle and reaction forces


@dataclass(frozen=True)
class HardSolved:
    """An equilibrium as a model judges it that has not solved anything, or why it was refused.

    smallest_jacobian bounds J everywhere from below; residual: of forces, relative; farthest: metres.
    """

    name: str
    refused: str = ""
    finite: bool = True
    smallest_jacobian: float = 1.0
    residual: float = 0.0
    farthest: float = 0.0


HardSolves: TypeAlias = Callable[[str], Iterator[HardSolved]]
"""Source of an anatomy -> what its cases come to."""


def hard_solves(source: str) -> Iterator[Result]:
    """Result after result of an anatomy; raises MissingExtraError without the offline part."""
    found = tuple(entry_points(group=ENTRY_POINT))
    if not found:
        raise MissingExtraError("solving the full model", "offline", "risorius_offline")
    solves: HardSolves = found[0].load()
    return map(as_result, solves(source))


def as_result(solved: HardSolved) -> Result:
    """A case passes that has come to an equilibrium without folds, or was refused and says why."""
    if solved.refused:
        return Result(solved.name, GROUP, PASSED, f"refused: {solved.refused}", refused=1)
    verdicts = {
        "not finite": solved.finite,
        "folded": solved.smallest_jacobian > 0.0,
        f"residual {solved.residual:.1e}": solved.residual <= TOLERANCE,
    }
    broken = [name for name, holds in verdicts.items() if not holds]
    return Result(
        name=solved.name,
        group=GROUP,
        outcome=FAILED if broken else PASSED,
        detail=", ".join(broken),
        frames=1,
        smallest_jacobian=solved.smallest_jacobian,
        farthest=solved.farthest,
    )
