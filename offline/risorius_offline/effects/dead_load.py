"""Forces that keep their magnitude and direction, such as weight."""

from __future__ import annotations

from dataclasses import dataclass

from risorius.jaw import FloatArray
from risorius_offline.effects.effect import NodeBlocks, Unobstructed


@dataclass(frozen=True)
class DeadLoad(Unobstructed):
    """Nodal forces (n, 3) in newtons; the energy is minus their work."""

    nodal_forces: FloatArray

    def set_parameters(self, parameters: FloatArray) -> None:
        """Do nothing: the load does not depend on the parameters."""

    def energy(self, u: FloatArray) -> float:
        """Minus the work of the load, joules."""
        return -float(self.nodal_forces.ravel() @ u.ravel())

    def add_forces(self, u: FloatArray, forces: FloatArray) -> float:
        """Add dE/du in newtons to `forces` (n, 3) and return the energy."""
        forces -= self.nodal_forces
        return self.energy(u)

    def second_derivatives(self, u: FloatArray, *, project: bool) -> NodeBlocks:
        """Return none: the energy is linear."""
        return NodeBlocks.none()
