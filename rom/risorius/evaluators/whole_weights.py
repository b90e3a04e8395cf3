"""Weights of a network as they are kept and used: whole numbers of eight bits."""

from __future__ import annotations

from dataclasses import dataclass, replace

import h5py
import numpy as np
import numpy.typing as npt

from risorius.paired_sums import LARGEST_WEIGHT
from risorius.whole_steps import Single

Places = npt.NDArray[np.int64]


@dataclass(frozen=True)
class WholeWeights:
    """Whole numbers (n, m) int8 of steps (m,): weights of n inputs in m sums."""

    numbers: npt.NDArray[np.int8]
    steps: Single

    @classmethod
    def of(cls, values: Single) -> WholeWeights:
        """Those next to values (n, m), of steps of which the largest of a column is LARGEST_WEIGHT."""
        steps = np.abs(values).max(axis=0, initial=0.0) / np.float32(LARGEST_WEIGHT)
        steps[steps == 0.0] = 1.0
        return cls(np.rint(values / steps).astype(np.int8), steps)

    @property
    def values(self) -> Single:
        """The weights (n, m)."""
        return self.numbers * self.steps

    def rows(self, which: Places) -> WholeWeights:
        """Return those of some inputs."""
        return replace(self, numbers=self.numbers[which])

    def columns(self, which: Places) -> WholeWeights:
        """Return those of some sums."""
        return WholeWeights(self.numbers[:, which], self.steps[which])

    def write(self, group: h5py.Group) -> None:
        """Store numbers and steps."""
        group["numbers"], group["steps"] = self.numbers, self.steps

    @classmethod
    def read(cls, group: h5py.Group) -> WholeWeights:
        """Load what `write` stored."""
        return cls(group["numbers"][()], group["steps"][()])
