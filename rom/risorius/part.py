"""What a scene leaves of a model: which of its parameters, coordinates and points."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

Numbers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Part:
    """Numbers of what is kept among those of the whole, ascending.

    parameters (p,), lifts (l,), modes (r,), carriers (c,) and vertices (n,) of a model of `lift_count` lifts.
    driven (p,): False for kept parameters that are always 0.
    """

    parameters: Numbers
    driven: npt.NDArray[np.bool_]
    lifts: Numbers
    modes: Numbers
    carriers: Numbers
    vertices: Numbers
    lift_count: int

    @cached_property
    def coordinates(self) -> Numbers:
        """Numbers (l + r,) of the lifts and modes among all coordinates."""
        return np.concatenate([self.lifts, self.lift_count + self.modes])

    def with_modes(self, modes: Numbers) -> Part:
        """Return the part with these modes instead."""
        return replace(self, modes=modes)
