"""What stops tissue of a full model that is pressed from rest."""

from __future__ import annotations

from risorius.mechanics.one_sided import OneSidedSprings
from risorius_offline.effects.bone_contact import BoneContact
from risorius_offline.effects.lip_seam import LipSeam
from risorius_offline.full_model import FullModel

REACH = 4e-3  # metres: a touch that takes tissue farther is refused


def springs_at_rest(model: FullModel) -> OneSidedSprings | None:
    """Springs of bones, teeth and the lips' seam; None without contact. Other contact of lips is not among them."""
    parts = [effect.springs_at_rest(REACH) for effect in model.effects if isinstance(effect, (BoneContact, LipSeam))]
    return OneSidedSprings.joined(parts) if parts else None
