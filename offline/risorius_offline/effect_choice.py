"""Which effects a full model has: what a run of snapshots or a single solve switches on."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from risorius.errors import InputError
from risorius.mechanics.fibres import HILL, PROPORTIONAL
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.contact_choice import ContactChoice
from risorius_offline.discretisation import Discretisation
from risorius_offline.effects.bone_contact import BoneContact
from risorius_offline.effects.effect import Effect
from risorius_offline.effects.gravity import UPRIGHT, gravity
from risorius_offline.effects.lip_contact import LipContact
from risorius_offline.effects.lip_overlap import LipOverlap
from risorius_offline.effects.lip_seam import LipSeam
from risorius_offline.effects.skin_contact import SkinContact, teeth_of
from risorius_offline.effects.skin_prestress import SkinPrestress
from risorius_offline.full_model import FullModel

# Of bones, metres: lips press with up to some 5 kPa, and then come 0.6 mm nearer than at rest. Half of it takes a third
# more Newton iterations.
GAP_TOLERANCE = 2e-3


@dataclass(frozen=True)
class EffectChoice:
    """What is off is absent and costs nothing.

    contact: lips and cheeks slide on teeth and bones, and on each other, at the lips' seam or anywhere; none is the
    seed's natural boundary.
    gravity: m/s2 in our axes (y up), as it acts on a face whose shape was taken upright; None is upright. prestress:
    of the skin at rest, pascals. force_length: muscles after Hill's curve instead of stress in proportion to stretch.
    """

    contact: ContactChoice = ContactChoice.NONE
    gravity: tuple[float, float, float] | None = None
    prestress: float = 0.0
    force_length: bool = False

    def __post_init__(self) -> None:
        if not 0.0 <= self.prestress < float("inf"):
            raise InputError(
                f"skin pre-stress {self.prestress:g} Pa; give a number from 0 on (living skin: 7e3 to 53e3)"
            )
        if self.gravity is not None and not all(map(math.isfinite, self.gravity)):
            raise InputError(f"gravity {self.gravity}; give three finite numbers in m/s2, y up")

    def model(self, anatomy: Anatomy) -> FullModel:
        """Full model of an anatomy with these effects; raises InputError for contact without bones."""
        effects: list[Effect] = []
        if self.contact != ContactChoice.NONE:
            effects.append(BoneContact(anatomy, GAP_TOLERANCE))
            if teeth_of(anatomy):
                effects.append(SkinContact(anatomy))
        if self.contact == ContactChoice.LIPS:
            effects += [LipSeam(anatomy), LipOverlap(anatomy)]
        if self.contact == ContactChoice.FULL:
            effects.append(LipContact(anatomy))
        if self.gravity is not None:
            effects.append(gravity(Discretisation(anatomy.points, anatomy.cells), self.gravity, UPRIGHT))
        if self.prestress:
            effects.append(SkinPrestress(anatomy.points, anatomy.skin, self.prestress))
        return FullModel(anatomy, effects, fibre_law=HILL if self.force_length else PROPORTIONAL)

    def provenance(self) -> Mapping[str, Any]:
        """What a file remembers of the choice."""
        return {f"effect_{name}": value for name, value in asdict(self).items()}
