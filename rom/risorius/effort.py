"""Work that muscles give off."""

from __future__ import annotations

import numpy as np

from risorius.hyper_reduction.muscles import ReducedMuscles
from risorius.jaw import FloatArray


class Effort:
    """Work of muscles for reduced coordinates: exact for the displacement that these describe, (7.2) and (7.3)."""

    def __init__(self, muscles: ReducedMuscles) -> None:
        self._stiffness = np.ascontiguousarray(muscles.stiffness, np.float32)
        self._pull = np.ascontiguousarray(muscles.pull, np.float32)

    def of(self, activations: FloatArray, coordinates: FloatArray) -> FloatArray:
        """Joules (m,) given off from rest to coordinates (r,), activations (m,) held; positive where one shortens."""
        q, works = coordinates.astype(np.float32), np.zeros(len(self._pull))
        for muscle in np.flatnonzero(activations):
            energy = 0.5 * (q @ (self._stiffness[muscle] @ q)) + self._pull[muscle] @ q
            works[muscle] = -activations[muscle] * energy
        return works
