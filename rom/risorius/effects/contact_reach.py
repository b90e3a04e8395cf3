"""What of the skin the inputs of a scene can bring to touch anything; the rest of contact is left out of its frames.

Gaps are taken from frames of a sample of the inputs, before contact has moved anything and after it. A point is left
out if it stays clear with a margin: MARGIN, and half of what its gap has shrunk by since it was at rest. At the corners
of the mouth, where the way downhill to the nearest triangle may end early, gaps are taken to shrink by as much as the
point and what is around it on the other lip have moved apart.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import ClassVar

import h5py
import numpy as np
import numpy.typing as npt

from risorius.contact_geometry import ContactGeometry
from risorius.effects.contact import Contact
from risorius.effects.contact_kernels import gaps_to_lips, gaps_to_teeth
from risorius.effects.contact_tables import ContactTables
from risorius.effects.effect import UPRIGHT, Surroundings
from risorius.evaluators.setting import Setting
from risorius.jaw import FloatArray
from risorius.part import Part

Flags = npt.NDArray[np.bool_]
Frames = Iterable[tuple[FloatArray, npt.NDArray[np.float32]]]
"""Coordinates (l + r,) and vertices (n, 3) of each, before contact."""

MARGIN = 0.25e-3  # metres
SHRUNK = 0.5  # of the shrinking of a gap
HEAVIEST = 1.01 * -UPRIGHT[1]  # m/s2: of frames that are sampled


class ReachableContact:
    """Contact that looks at `some` of the points where nothing but inputs, weight and inertia acts, else at `all`."""

    name: ClassVar[str] = Contact.name
    needs: ClassVar[str] = Contact.needs
    energy: ClassVar[float] = 0.0

    def __init__(self, some: Contact, everything: Contact) -> None:
        self.fields = everything.fields
        self._some, self._everything = some, everything
        self._acting = some

    @property
    def tables(self) -> ContactTables:
        """Of the points that are looked at."""
        return self._some.tables

    @property
    def geometry(self) -> ContactGeometry:
        """What skin can touch."""
        return self._everything.geometry

    @classmethod
    def of(cls, contact: Contact, rest: npt.NDArray[np.float32], frames: Frames) -> ReachableContact:
        """Contact for inputs that bring about `frames` of a face at rest (n, 3)."""
        tables = contact.tables
        some = Contact(tables.only(*reachable(contact, rest, frames)), contact.retreat, contact.geometry, len(contact.fields))
        return cls(some, contact)

    def check(self, surroundings: Surroundings) -> None:
        """Nothing: it shows what it can, whatever acts from outside."""

    def drive(self, parameters: FloatArray, surroundings: Surroundings) -> Surroundings:
        """Nothing: contact does not change what muscles do."""
        return surroundings

    def respond(
        self, parameters: FloatArray, coordinates: FloatArray, own: FloatArray, surroundings: Surroundings
    ) -> None:
        """Remember whether anything acts that no sample tells of."""
        gravity = surroundings.gravity
        sampled = not surroundings.touches and (gravity is None or gravity @ gravity <= HEAVIEST * HEAVIEST)
        self._acting = self._some if sampled else self._everything

    def finish(self, coordinates: FloatArray, vertices: npt.NDArray[np.float32]) -> None:
        """Move vertices (n, 3) out of teeth and lips, in place."""
        self._acting.finish(coordinates, vertices)

    def at(self, setting: Setting) -> ReachableContact:
        """See `Effect`."""
        return ReachableContact(self._some.at(setting), self._everything.at(setting))

    def within(self, part: Part) -> ReachableContact:
        """See `Effect`."""
        return ReachableContact(self._some.within(part), self._everything.within(part))

    def in_axes(self, order: tuple[int, int, int]) -> ReachableContact:
        """See `Effect`."""
        return ReachableContact(self._some.in_axes(order), self._everything.in_axes(order))

    def write(self, group: h5py.Group) -> None:
        """Store what is looked at where anything may act."""
        self._everything.write(group)

    @classmethod
    def read(cls, group: h5py.Group) -> Contact:
        """Load what `write` stored."""
        return Contact.read(group)


def reachable(contact: Contact, rest: npt.NDArray[np.float32], frames: Frames) -> tuple[Flags, Flags]:
    """Points (k,) for teeth and vertices (l,) of the lips that frames of a face at rest (n, 3) let come to touch."""
    gaps = _Gaps(contact.tables)
    at_rest = tuple(gap.copy() for gap in gaps.of(np.zeros(contact.tables.transforms.shape[0]), rest))
    least = tuple(gap.copy() for gap in at_rest)
    for coordinates, vertices in frames:
        for _ in range(2):
            for smallest, now in zip(least, gaps.of(coordinates, vertices), strict=True):
                np.minimum(smallest, now, out=smallest)
            contact.finish(coordinates, vertices)
    first, second = (
        gap - np.maximum(MARGIN, SHRUNK * (before - gap)) <= 0.0 for before, gap in zip(at_rest, least, strict=True)
    )
    return first, second | (np.diff(contact.tables.candidate_starts) > 0)


class _Gaps:
    """Gaps of all points of tables, one frame after another."""

    def __init__(self, tables: ContactTables) -> None:
        self._tables = tables
        points, lips = len(tables.points), len(tables.vertices)
        self._which = np.arange(max(points, lips), dtype=np.int32)
        self._teeth, self._ways = np.empty(points), np.empty((points, 3))
        self._lips, self._ways_lips = np.empty(lips), np.empty((lips, 3))

    def of(self, coordinates: FloatArray, vertices: npt.NDArray[np.float32]) -> tuple[FloatArray, FloatArray]:
        """Gaps (k,) to teeth and (l,) to the other lip; the next call overwrites them."""
        t, at = self._tables, self._tables.facing.copy()
        gaps_to_teeth(
            vertices, t.points, self._which, len(t.points), t.onset, t.away, t.distances, t.starts, t.shapes, t.lows,
            t.spacings, t.moves, *t.least, *t.jaw(coordinates), self._teeth, self._ways,
        )  # fmt: skip
        gaps_to_lips(
            vertices, t.vertices, self._which, len(t.vertices), at, t.places, t.triangles, t.across, t.planes,
            float(t.orientation[0]), self._lips, self._ways_lips,
        )  # fmt: skip
        return self._teeth, self._lips
