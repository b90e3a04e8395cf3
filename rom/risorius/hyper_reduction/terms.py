"""What a term of the reduced energy is: elements side by side, each a function of the displacement of its nodes."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.floating]


class Term(Protocol):
    """Elements with the nodes connectivity (e, a) and a state, which `deform` sets and the others read."""

    connectivity: npt.NDArray[np.int64]

    def deform(self, u: Floats) -> None:
        """Take the displacement (3 a, e) of the nodes of every element, metres."""
        ...

    def energy(self) -> float:
        """Joules; finite for every displacement."""
        ...

    def forces(self) -> Floats:
        """Derivatives (3 a, e) of the energy by the displacement, newtons; the next call may overwrite them."""
        ...

    def product(self, v: Floats) -> Floats:
        """Change (3 a, e) of the forces with a change v (3 a, e) of the displacement; see `forces`."""
        ...

    def smallest_jacobian(self) -> float:
        """Smallest J where the term looks at it, else infinity."""
        ...
