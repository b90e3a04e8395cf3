"""Superposition of single actions, (7.8): u = sum_i w_i u^i. Exact only if tissue were linear."""

from __future__ import annotations

from dataclasses import dataclass

import h5py
import numpy as np

from risorius.evaluators.setting import Setting
from risorius.jaw import FloatArray
from risorius.part import Part


@dataclass(frozen=True)
class Superposition:
    """actions: (p, r) modal coordinates of every single parameter at weight 1."""

    actions: FloatArray
    name = "superposition"
    doubt = 0.0

    def coordinates(self, parameters: FloatArray, out: FloatArray) -> None:
        """Write the modal coordinates (r,) of parameters (p,) into `out`."""
        np.dot(parameters, self.actions, out=out)

    def at(self, setting: Setting) -> Superposition:
        """Return that of the leading modes."""
        return Superposition(np.ascontiguousarray(self.actions[:, : setting.rank]))

    def within(self, part: Part) -> Superposition:
        """Return that of the parameters and modes of a part."""
        return Superposition(np.ascontiguousarray(self.actions[np.ix_(part.parameters, part.modes)]))

    def write(self, group: h5py.Group) -> None:
        """Store the single actions."""
        group["actions"] = self.actions

    @classmethod
    def read(cls, group: h5py.Group) -> Superposition:
        """Load what `write` stored."""
        return cls(group["actions"][()])
