"""Forces between bones or tarsal plates and the tissue that is fixed to them."""

from __future__ import annotations

from dataclasses import dataclass

from risorius.jaw import FloatArray
from risorius_offline.equilibrium import Equilibrium
from risorius_offline.full_model import FullModel


@dataclass(frozen=True)
class Reactions:
    """Resultant forces (3,) in newtons with which skull, jaw and both upper lids hold the nodes fixed to them.

    At an equilibrium they balance the external loads: without loads their sum is zero. A node on both bones counts as
    jaw.
    """

    skull: FloatArray
    jaw: FloatArray
    lids: FloatArray


def bone_reactions(model: FullModel, equilibrium: Equilibrium) -> Reactions:
    """Reactions at an equilibrium: the derivative of the energy at the fixed nodes, summed over each bone."""
    model.set_parameters(equilibrium.parameters)
    _, _, forces = model.forces(equilibrium.u)
    jaw = model.anatomy.jaw
    skull = model.anatomy.skull & ~jaw
    lids = model.anatomy.prescribed & ~(skull | jaw)
    return Reactions(*(forces[held].sum(axis=0) for held in (skull, jaw, lids)))
