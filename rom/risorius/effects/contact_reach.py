"""What of the skin the inputs of a scene can bring to touch anything; the rest of contact is left out of its frames.

Gaps are taken from frames of a sample of the inputs, before contact has moved anything and after it. A point is left
out if it stays clear by MARGIN, and by half of what its gap has shrunk by since it was at rest. Neither touches nor a
head that is shaken are in the sample: in their frames everything is looked at.
"""

from __future__ import annotations

from collections.abc import Iterable

import h5py
import numpy as np
import numpy.typing as npt

from risorius.effects.contact import Contact
from risorius.effects.contact_groups import LipGroups
from risorius.effects.contact_tables import ContactTables
from risorius.effects.effect import UPRIGHT, Surroundings
from risorius.evaluators.setting import Setting
from risorius.guard import UNFOLDED
from risorius.jaw import FloatArray
from risorius.part import Part

Flags = npt.NDArray[np.bool_]
Frames = Iterable[tuple[FloatArray, npt.NDArray[np.float32]]]
"""Coordinates (l + r,) and vertices (n, 3) of each, before contact."""

MARGIN = 0.25e-3  # metres
SHRUNK = 0.5  # of the shrinking of a gap
HEAVIEST = 1.01 * -UPRIGHT[1]  # m/s2: of frames that are sampled


class ReachableContact(Contact):
    """Contact that looks at the points of `tables` where nothing but inputs, weight and inertia acts, else at all."""

    def __init__(self, tables: ContactTables, everything: Contact, groups: LipGroups | None = None) -> None:
        super().__init__(tables, everything.retreat, everything.geometry, everything.fields.shape[1], groups)
        self._everything, self._sampled = everything, True

    @classmethod
    def of(cls, contact: Contact, rest: npt.NDArray[np.float32], frames: Frames) -> ReachableContact:
        """Contact for inputs that bring about `frames` of a face at rest (n, 3)."""
        return cls(contact.tables.only(*reachable(contact, rest, frames)), contact)

    def respond(
        self, parameters: FloatArray, coordinates: FloatArray, own: FloatArray, surroundings: Surroundings
    ) -> None:
        """Remember whether anything acts that no sample tells of."""
        gravity = surroundings.gravity
        light = gravity is None or bool(gravity @ gravity <= HEAVIEST * HEAVIEST)
        self._sampled = light and not surroundings.touches

    def finish(
        self, coordinates: FloatArray, vertices: npt.NDArray[np.float32], folds: FloatArray | None = UNFOLDED
    ) -> None:
        """Move vertices (n, 3) out of teeth and lips, in place."""
        if self._sampled:
            super().finish(coordinates, vertices, folds)
        else:
            self._everything.finish(coordinates, vertices, folds)
            self.gave_way = self._everything.gave_way

    def restart(self) -> None:
        """Forget what was near what, and any number that is none."""
        super().restart()
        self._everything.restart()

    def at(self, setting: Setting) -> ReachableContact:
        """Return the effect with a state of its own; it is the same for any number of modes."""
        return ReachableContact(self.tables, self._everything.at(setting), self.groups)

    def within(self, part: Part) -> ReachableContact:
        """Return the effect of what a part holds of the lips."""
        return ReachableContact(self.tables.within(part), self._everything.within(part))

    def in_axes(self, order: tuple[int, int, int]) -> ReachableContact:
        """Return the effect for vertices whose components are in another order."""
        return ReachableContact(self.tables.in_axes(order), self._everything.in_axes(order))

    def write(self, group: h5py.Group) -> None:
        """Store what is looked at where anything may act."""
        self._everything.write(group)


def reachable(contact: Contact, rest: npt.NDArray[np.float32], frames: Frames) -> tuple[Flags, Flags]:
    """Points (k,) for teeth and vertices (l,) of the lips that frames of a face at rest (n, 3) let come to touch."""
    at_rest = contact.gaps(np.zeros(contact.tables.transforms.shape[0]), rest)
    least = [gaps.copy() for gaps in at_rest]
    for coordinates, vertices in frames:
        for _ in range(2):
            for smallest, now in zip(least, contact.gaps(coordinates, vertices), strict=True):
                np.minimum(smallest, now, out=smallest)
            contact.finish(coordinates, vertices)
    first, second = (
        gaps - np.maximum(MARGIN, SHRUNK * (before - gaps)) <= 0.0 for before, gaps in zip(at_rest, least, strict=True)
    )
    return first, second
