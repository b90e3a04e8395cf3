"""Contact: skin that the map has put into teeth, or a lip that it has put into the other, is moved out of there.

The map was trained with contact and knows of most of it. What is left is found at the points of the skin that may touch
and pushed out along smooth fields around them, at most `SWEEPS` times in a frame, all in place. Where something is
still too deep, the mouth goes back part of the way to where nothing touches, and is pushed out from there.
"""

from __future__ import annotations

import math
from dataclasses import fields
from typing import ClassVar

import h5py
import numpy as np
import numpy.typing as npt

from risorius.contact_geometry import ContactGeometry
from risorius.effects.contact_groups import LipGroups
from risorius.effects.contact_look import ContactLook
from risorius.effects.contact_tables import ContactTables, contact_tables, frames_of
from risorius.effects.effect import Surroundings
from risorius.effects.lip_gaps import DUBIOUS, TOLERATED
from risorius.effects.retreat import Retreat
from risorius.effects.teeth_gaps import move_jaw
from risorius.evaluators.setting import Setting
from risorius.guard import UNFOLDED
from risorius.jaw import FloatArray
from risorius.part import Part
from risorius.snapshot_file import SnapshotSet

Numbers = npt.NDArray[np.int64]
SHARES = (0.125, 0.25, 0.5, 1.0)  # of the way back, tried in turn
SHALLOW = 0.2e-3  # metres: equilibria have lips as deep in each other, and where nothing is deeper nothing is moved
HOPELESS = 0.97  # of a depth: where a round of sweeps leaves more, another will
PROOFS = 2  # rounds of sweeps at most, out of what a look that makes sure has found


class Contact:
    """The effect. Not thread-safe: it owns what it works with. fields: none of its own, of `carriers` points.

    gave_way: metres that going back has taken any vertex in the last frame; 0 where the mouth did not go back.
    """

    name: ClassVar[str] = "contact"
    needs: ClassVar[str] = "snapshots with contact, made with --contact lips"
    energy: ClassVar[float] = 0.0

    def __init__(
        self, tables: ContactTables, retreat: Retreat, geometry: ContactGeometry, carriers: int,
        groups: LipGroups | None = None,
    ) -> None:  # fmt: skip
        self.tables, self.retreat, self.geometry = tables, retreat, geometry
        self.fields = np.zeros((0, carriers, 3), np.float32)
        self._turn, self._origin = np.eye(3), np.zeros(3)
        self.gave_way = 0.0
        self.groups = groups or LipGroups.of(tables, retreat.rest)
        self._look = ContactLook(tables, self.groups, retreat, self._turn, self._origin)
        self._targets = np.empty_like(retreat.places)
        self._before, self._best = np.empty((2, len(tables.row_starts) - 1, 3), np.float32)

    @classmethod
    def train(cls, snapshots: SnapshotSet, fields: FloatArray) -> Contact | None:
        """Return that of snapshots that were solved with contact, else None."""
        if snapshots.contact is None:
            return None
        surface = snapshots.surface
        rest, triangles = surface.points.astype(np.float32), surface.triangles.astype(np.int32)
        tables = contact_tables(snapshots.contact, snapshots.poses, rest, triangles, frames_of(snapshots))
        lifts = np.array([surface.weights @ field for field in snapshots.lift_fields])
        touching = np.union1d(tables.points, tables.vertices)
        retreat = Retreat.of(snapshots.contact, snapshots.poses, lifts, rest, triangles, touching)
        return cls(tables, retreat, snapshots.contact, len(np.unique(surface.weights.indices)))

    def check(self, surroundings: Surroundings) -> None:
        """Nothing: it shows what it can, whatever acts from outside."""

    def drive(self, parameters: FloatArray, surroundings: Surroundings) -> Surroundings:
        """Nothing: contact does not change what muscles do."""
        return surroundings

    def respond(
        self, parameters: FloatArray, coordinates: FloatArray, own: FloatArray, surroundings: Surroundings
    ) -> None:
        """Nothing: it is the vertices that touch."""

    def finish(
        self, coordinates: FloatArray, vertices: npt.NDArray[np.float32], folds: FloatArray | None = UNFOLDED
    ) -> None:
        """Move vertices (n, 3) out of teeth and lips, in place."""
        self.gave_way = 0.0
        if self.sweep(coordinates, vertices, folds) > TOLERATED:
            self._go_back(coordinates, vertices, folds)

    def sweep(
        self, coordinates: FloatArray, vertices: npt.NDArray[np.float32], folds: FloatArray | None = UNFOLDED
    ) -> float:
        """Do so without going back; return metres that anything is left in anything, negative where nothing is.

        What the quick look takes for deep may be beside the other lip, above all in tissue that was folded. So where
        following it leaves anything too deep, only what is proven is followed.
        """
        move_jaw(coordinates, self.tables.transforms, self._turn, self._origin)
        depth = self._look.find(vertices, folds is not UNFOLDED)
        if depth < SHALLOW and folds is UNFOLDED:
            return depth
        self._before[:] = vertices
        return self._sweep_found(vertices, folds, depth)

    def _sweep_found(self, vertices: npt.NDArray[np.float32], folds: FloatArray | None, found: float) -> float:
        """Move vertices out of what the quick look has found, then of what is proven to be left; return what then is.

        Further rounds are made for as long as they take anything off.
        """
        unsure = self._look.unsure_places() if found > DUBIOUS else UNFOLDED
        if len(unsure):
            self._look.make_sure(vertices, unsure)
            self._look.adopt()
        self._look.sweep(vertices)
        depth = self._look.make_sure(vertices, folds)
        for _ in range(PROOFS):
            if depth <= TOLERATED:
                break
            self._look.adopt()
            self._look.sweep(vertices)
            before, depth = depth, self._look.make_sure(vertices, folds)
            if depth > HOPELESS * before:
                break
        return depth

    def gaps(self, coordinates: FloatArray, vertices: npt.NDArray[np.float32]) -> tuple[FloatArray, FloatArray]:
        """Metres (k,) from teeth and (l,) from the other lip of all points that are looked at, of vertices (n, 3)."""
        move_jaw(coordinates, self.tables.transforms, self._turn, self._origin)
        return self._look.gaps(vertices)

    def _go_back(self, coordinates: FloatArray, vertices: npt.NDArray[np.float32], folds: FloatArray | None) -> None:
        """Let the mouth go back as little of the way as leaves nothing too deep, or least deep where nothing does."""
        self.retreat.aim(coordinates, self.tables.transforms, self._targets)
        least = math.inf
        for share in SHARES:
            vertices[:] = self._before
            way = self.retreat.go(share, self._targets, self._before, vertices)
            depth = self._sweep_found(vertices, folds, self._look.find(vertices, folds is not UNFOLDED))
            if depth < least:
                least, self.gave_way = depth, way
                self._best[:] = vertices
            if depth <= TOLERATED:
                return
        vertices[:] = self._best

    def _warm_up(self) -> None:
        """Look at a face at rest, make sure of all of it and go back from it."""
        at_rest, vertices = np.zeros(len(self.tables.transforms)), self.retreat.rest.copy()
        self._before[:] = vertices
        self._look.find(vertices, True)
        self._look.make_sure(vertices, UNFOLDED)
        self._look.adopt()
        self._go_back(at_rest, vertices, None)
        self.restart()

    def restart(self) -> None:
        """Forget what was near what, and any number that is none."""
        self.gave_way = 0.0
        self._look.restart()

    def at(self, setting: Setting) -> Contact:
        """Return the effect with a state of its own; it is the same for any number of modes.

        What few frames need is compiled here, so that none of them waits for it.
        """
        effect = Contact(self.tables, self.retreat, self.geometry, self.fields.shape[1], self.groups)
        effect._warm_up()
        return effect

    def within(self, part: Part) -> Contact:
        """Return the effect of what a part holds of the lips."""
        return Contact(self.tables.within(part), self.retreat.within(part), self.geometry, len(part.carriers))

    def in_axes(self, order: tuple[int, int, int]) -> Contact:
        """Return the effect for vertices whose components are in another order."""
        return Contact(self.tables.in_axes(order), self.retreat.in_axes(order), self.geometry, self.fields.shape[1])

    def write(self, group: h5py.Group) -> None:
        """Store tables and geometry."""
        group.attrs["carriers"] = self.fields.shape[1]
        self.geometry.write(group.create_group("geometry"))
        tables = group.create_group("tables")
        for field in fields(self.tables):
            tables[field.name] = getattr(self.tables, field.name)
        self.retreat.write(group.create_group("retreat"))

    @classmethod
    def read(cls, group: h5py.Group) -> Contact:
        """Load what `write` stored."""
        tables = ContactTables(**{field.name: group["tables"][field.name][()] for field in fields(ContactTables)})
        geometry, retreat = ContactGeometry.read(group["geometry"]), Retreat.read(group["retreat"])
        return cls(tables, retreat, geometry, int(group.attrs["carriers"]))
