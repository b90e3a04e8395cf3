"""What the steps since a factorisation have shown of the tangent, for steps with factors that are no longer exact.

BFGS updates of the factors' inverse (Matthies and Strang 1979), by the two loops of Nocedal (1980).
"""

from __future__ import annotations

from collections.abc import Callable

from risorius.jaw import FloatArray


class Secants:
    """Differences of positions (f,) and of gradients (f,) between one visited state and the next."""

    def __init__(self) -> None:
        self._pairs: list[tuple[FloatArray, FloatArray, float]] = []
        self._last: tuple[FloatArray, FloatArray] | None = None

    def visit(self, position: FloatArray, gradient: FloatArray) -> None:
        """Take the next state; a difference along which the energy is not convex is left out."""
        if self._last is not None:
            step, change = position - self._last[0], gradient - self._last[1]
            curvature = float(step @ change)
            if curvature > 0.0:
                self._pairs.append((step, change, curvature))
        self._last = position, gradient

    def forget(self) -> None:
        """Keep the last state only: the factors are new."""
        self._pairs.clear()

    def solve(self, factors: Callable[[FloatArray], FloatArray], gradient: FloatArray) -> FloatArray:
        """Solution (f,) with the updated factors."""
        rest, shares = gradient, []
        for step, change, curvature in reversed(self._pairs):
            shares.append(float(step @ rest) / curvature)
            rest = rest - shares[-1] * change
        solution = factors(rest)
        for step, change, curvature in self._pairs:
            solution = solution + (shares.pop() - float(change @ solution) / curvature) * step
        return solution
