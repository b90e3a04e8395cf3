"""What an effect is: energy, forces, second derivatives, and how far a step may go."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray


@dataclass(frozen=True)
class NodeBlocks:
    """Dense symmetric second derivatives between few nodes: nodes (k, m), matrices (k, 3 m, 3 m) in N/m."""

    nodes: IntArray
    matrices: FloatArray

    @classmethod
    def none(cls) -> NodeBlocks:
        """No second derivatives at all."""
        return cls(np.zeros((0, 1), dtype=np.int64), np.zeros((0, 3, 3)))


class Unobstructed:
    """Part of an effect that admits every displacement: nothing is pushed out, noted, and no step is shortened."""

    notes: object = None

    def admits(self, u: FloatArray) -> bool:
        """Return True."""
        return True

    def push_out(self, u: FloatArray) -> None:
        """Nothing."""

    def note(self, u: FloatArray) -> None:
        """Nothing."""

    def missed(self, u: FloatArray) -> float:
        """Return 0."""
        return 0.0

    def largest_step(self, u: FloatArray, direction: FloatArray) -> float:
        """Return 1."""
        return 1.0


class Effect(Protocol):
    """A term of the energy besides tissue and active stress. u is (n, 3) in metres, C-contiguous float64.

    notes: of what touches, which the energy rests on; None where it does not.
    """

    notes: object

    def set_parameters(self, parameters: FloatArray) -> None:
        """Take the parameters (p,), muscle activations and then pose weights, for all later calls."""
        ...

    def energy(self, u: FloatArray) -> float:
        """Joules; infinite where u is not admissible."""
        ...

    def add_forces(self, u: FloatArray, forces: FloatArray) -> float:
        """Add dE/du in newtons to `forces` (n, 3) and return the energy."""
        ...

    def second_derivatives(self, u: FloatArray, *, project: bool) -> NodeBlocks:
        """Second derivatives of the energy; with `project` every block is positive semi-definite."""
        ...

    def admits(self, u: FloatArray) -> bool:
        """Whether u may be started from: as far as it alone can tell, no surface has gone through another."""
        ...

    def push_out(self, u: FloatArray) -> None:
        """Move nodes of u, in place, to where it admits them, as far as it can tell where that is."""
        ...

    def note(self, u: FloatArray) -> None:
        """Take note of what touches at u, for all later calls, instead of what was noted before."""
        ...

    def missed(self, u: FloatArray) -> float:
        """Metres by which something at u is deeper in something than what was noted has it; 0 where all is noted."""
        ...

    def largest_step(self, u: FloatArray, direction: FloatArray) -> float:
        """Fraction in (0, 1] of `direction` (n, 3) that stays admissible all along."""
        ...
