"""What people ask of an equilibrium, one subject a file: skin, muscles, bones."""

from risorius_offline.quantities.bones import Reactions, bone_reactions
from risorius_offline.quantities.muscles import MuscleState, muscle_state
from risorius_offline.quantities.skin import SkinState, skin_state

__all__ = ["MuscleState", "Reactions", "SkinState", "bone_reactions", "muscle_state", "skin_state"]
