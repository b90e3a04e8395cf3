"""Forces between the bones and the tissue that is fixed to them."""

from __future__ import annotations

from dataclasses import dataclass

from risorius.jaw import FloatArray
from risorius_offline.equilibrium import Equilibrium
from risorius_offline.full_model import FullModel


@dataclass(frozen=True)
class Reactions:
    """Resultant forces (3,) in newtons with which skull and jaw hold the nodes fixed to them.

    At an equilibrium they balance the external loads: without loads their sum is zero. A node on both counts as jaw.
    """

    skull: FloatArray
    jaw: FloatArray


def bone_reactions(model: FullModel, equilibrium: Equilibrium) -> Reactions:
    """Reactions at an equilibrium: the derivative of the energy at the fixed nodes, summed over each bone."""
    model.set_parameters(equilibrium.parameters)
    _, _, forces = model.forces(equilibrium.u)
    jaw = model.anatomy.jaw
    return Reactions(skull=forces[model.anatomy.skull & ~jaw].sum(axis=0), jaw=forces[jaw].sum(axis=0))
