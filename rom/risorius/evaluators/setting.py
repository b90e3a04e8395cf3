"""How an evaluator is run: what buys accuracy for time."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Setting:
    """method: name of the evaluator. rank: modes that are used, the leading ones.

    elements, steps: sampled elements and iterations of an evaluator that corrects; 0 where there are none. Both are
    fixed numbers, so that they cap the time of every frame.
    """

    method: str
    rank: int
    elements: int = 0
    steps: int = 0

    def __str__(self) -> str:
        parts = [f"{self.method}, {self.rank} modes"]
        parts += [f"{self.elements} elements"] if self.elements else []
        parts += [f"{self.steps} steps"] if self.steps else []
        return ", ".join(parts)
