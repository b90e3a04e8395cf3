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


NO_CONTACTS: IntArray = np.zeros((0, 4), dtype=np.int64)


class WithoutContactPairs:
    """Part of an effect that holds no contact pairs: what touches, if anything can, its energy finds by itself."""

    @property
    def contacts(self) -> IntArray:
        """No pairs."""
        return NO_CONTACTS

    def search_contacts(self, u: FloatArray) -> IntArray:
        """Return no pairs."""
        return NO_CONTACTS

    def hold_contacts(self, contacts: IntArray) -> None:
        """Nothing."""

    def missed_depth(self, u: FloatArray, contacts: IntArray) -> float:
        """Return 0."""
        return 0.0


class Unobstructed(WithoutContactPairs):
    """Part of an effect that admits every displacement: nothing is pushed out, and no step is shortened."""

    def admits(self, u: FloatArray) -> bool:
        """Return True."""
        return True

    def push_out(self, u: FloatArray) -> None:
        """Nothing."""

    def largest_step(self, u: FloatArray, direction: FloatArray) -> float:
        """Return 1."""
        return 1.0


class Effect(Protocol):
    """A term of the energy besides tissue and active stress. u is (n, 3) in metres, C-contiguous float64."""

    @property
    def contacts(self) -> IntArray:
        """The active set: pairs (c, 4) of a point and the corners of a triangle, of which the energy is.

        None where the energy finds what touches by itself.
        """
        ...

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

    def search_contacts(self, u: FloatArray) -> IntArray:
        """Contact pairs (c, 4) at u; those that the effect holds stay."""
        ...

    def hold_contacts(self, contacts: IntArray) -> None:
        """Hold contact pairs (c, 4) in place of those before, for all later calls."""
        ...

    def missed_depth(self, u: FloatArray, contacts: IntArray) -> float:
        """Metres by which something at u is deeper in something by `contacts` than by those that the effect holds."""
        ...

    def largest_step(self, u: FloatArray, direction: FloatArray) -> float:
        """Fraction in (0, 1] of `direction` (n, 3) that stays admissible all along."""
        ...
