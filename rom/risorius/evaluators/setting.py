"""How an evaluator is run: what buys accuracy for time."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from risorius.part import Part


@dataclass(frozen=True)
class Setting:
    """method: name of the evaluator. rank: modes that are used, the leading ones.

    elements, steps: sampled elements and iterations of an evaluator that corrects; 0 where there are none. Both are
    fixed numbers, so that they cap the time of every frame. lower: how many of the modes are the lower half, where the
    setting is that of a part of a model, which may have lost more of either; -1 for half of them.
    """

    method: str
    rank: int
    elements: int = 0
    steps: int = 0
    lower: int = -1

    @property
    def middle(self) -> int:
        """First mode of the upper half."""
        return (self.rank + 1) // 2 if self.lower < 0 else self.lower

    def within(self, part: Part) -> Setting:
        """Return the setting that uses those modes of a part that this one uses of the whole."""
        rank, middle = np.searchsorted(part.modes, [self.rank, self.middle])
        return replace(self, rank=int(rank), lower=int(middle))

    def __str__(self) -> str:
        parts = [f"{self.method}, {self.rank} modes"]
        parts += [f"{self.elements} elements"] if self.elements else []
        parts += [f"{self.steps} step{'s' if self.steps > 1 else ''}"] if self.steps else []
        return ", ".join(parts)
