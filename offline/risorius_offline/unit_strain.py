"""The size of a body's energy and forces at strains of order one: what rounding is relative to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from risorius.mechanics.material import Yeoh
from risorius_offline.discretisation import Discretisation


@dataclass(frozen=True)
class UnitStrain:
    """Energy (J) and norm of the nodal forces (N), both of the order of unit strain."""

    energy: float
    force: float

    @classmethod
    def of(cls, discretisation: Discretisation, materials: tuple[Yeoh, ...]) -> UnitStrain:
        """The logarithm of J rounds by c10 in the energy, the dilatation by the bulk modulus in the forces."""
        c10, bulk = (np.array([getattr(material, name) for material in materials]) for name in ("c10", "bulk"))
        layer = np.concatenate([block.cells.layer for block in discretisation.volumes])
        volume = np.concatenate([block.weights.sum(axis=1) for block in discretisation.volumes])
        return cls(float(c10[layer] @ volume), float(np.linalg.norm(bulk[layer] * volume ** (2 / 3))))
