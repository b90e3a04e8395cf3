"""What springs that only push do to elastic tissue that is pressed against them.

With the flexibility D of the tissue between the springs, openings s_0 of their gaps without them and forces f(s) that
grow with the square of the overlap, s = s_0 + D f(s): the minimum of a convex energy, found by Newton steps.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from risorius.jaw import FloatArray
from risorius.mechanics.one_sided import OneSidedSprings

MOST = 96  # springs that take part, those that are pressed most
ROUNDS = 3  # of looking for further ones
ENOUGH = 1e-8  # metres
STEPS = 50
Numbers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class _Group:
    """Springs that take part: numbers (a,); opens (a, k), what a newton of each opens of all gaps; moves (a, c)."""

    numbers: Numbers
    opens: FloatArray
    moves: FloatArray


class Reactions:
    """solve: from loads (m, a) on the tissue to displacements (m, a). seen (c,): what is wanted of these.

    Not thread-safe: it keeps what a newton of each spring does, and the last openings, from which the next are found.
    """

    def __init__(self, springs: OneSidedSprings, solve: Callable[[FloatArray], FloatArray], seen: Numbers) -> None:
        self.springs = springs
        self._solve, self._seen = solve, seen
        self._kept: dict[int, tuple[FloatArray, FloatArray]] = {}
        self.restart()

    def restart(self) -> None:
        """Forget the last touch; what single springs do is kept."""
        self._place: Hashable = None
        self._group, self._openings = self._of(np.zeros(0, np.int64)), np.zeros(0)

    def displacement(self, opening: FloatArray, place: Hashable) -> FloatArray:
        """What springs add to the displacement (c,) of tissue that has opened their gaps by (k,) without them.

        place: of the touch. Springs that have taken part there do again, so that they are not looked for in each frame.
        """
        if place != self._place:
            self._place, self._group = place, self._of(np.zeros(0, np.int64))
            self._take(self._pressed(opening, MOST), opening)
        forces = self._forces(opening[self._group.numbers])
        for _ in range(ROUNDS):
            push = self._group.numbers[forces > 0.0]
            pressed = self._pressed(opening + forces @ self._group.opens, MOST - len(push))
            if not len(pressed):
                break
            self._take(np.concatenate([push, pressed]), opening)
            forces = self._forces(opening[self._group.numbers])
        return np.asarray(forces @ self._group.moves)

    def _pressed(self, opening: FloatArray, most: int) -> Numbers:
        """At most so many springs that take no part yet, those that overlap most."""
        overlap = -self.springs.play - opening
        overlap[self._group.numbers] = 0.0
        found = np.flatnonzero(overlap > ENOUGH)
        return found[np.argsort(-overlap[found], kind="stable")[:most]]

    def _take(self, numbers: Numbers, opening: FloatArray) -> None:
        self._group, self._openings = self._of(numbers), opening[numbers]

    def _of(self, numbers: Numbers) -> _Group:
        new = [number for number in numbers if number not in self._kept]
        if new:
            found = self._solve(np.asarray(self.springs.rows[new].toarray().T))
            for column, number in enumerate(new):
                self._kept[number] = self.springs.rows @ found[:, column], found[self._seen, column]
        kept = [self._kept[number] for number in numbers]
        opens = np.array([each[0] for each in kept]).reshape(len(kept), len(self.springs.play))
        return _Group(numbers, opens, np.array([each[1] for each in kept]).reshape(len(kept), len(self._seen)))

    def _forces(self, free: FloatArray) -> FloatArray:
        """Newtons (a,) of the springs that take part, whose gaps open by (a,) without them."""
        play, strength = (values[self._group.numbers] for values in (self.springs.play, self.springs.strength))
        flexibility = self._group.opens[:, self._group.numbers]
        opening = self._openings
        for _ in range(STEPS):
            overlap = np.maximum(-play - opening, 0.0)
            missed = opening - free - (strength * overlap**2) @ flexibility
            if np.abs(missed).max(initial=0.0) < ENOUGH:
                break
            active = np.flatnonzero(overlap)
            slope = flexibility[active].T * (2.0 * strength * overlap)[active]
            inner = np.linalg.solve(np.eye(len(active)) + slope[active], -missed[active])
            opening = opening - missed - slope @ inner
        self._openings = opening
        return np.asarray(strength * np.maximum(-play - opening, 0.0) ** 2)
