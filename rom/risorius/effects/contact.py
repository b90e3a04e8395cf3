"""Contact: skin that the map has put into teeth, or a lip that it has put into the other, is moved out of there.

The map was trained with contact and knows of most of it. What is left is found at a few hundred points of the skin and
pushed out along smooth fields around them, at most `SWEEPS` times in a frame, all in place.
"""

from __future__ import annotations

from dataclasses import fields
from typing import ClassVar

import h5py
import numpy as np
import numpy.typing as npt

from risorius.contact_geometry import ContactGeometry
from risorius.effects.contact_kernels import resolve
from risorius.effects.contact_tables import ContactTables, contact_tables, frames_of
from risorius.effects.effect import Surroundings
from risorius.evaluators.setting import Setting
from risorius.jaw import FloatArray
from risorius.part import Part
from risorius.snapshot_file import SnapshotSet


class Contact:
    """The effect. Not thread-safe: it owns what it works with. fields: none of its own, of `carriers` points."""

    name: ClassVar[str] = "contact"
    needs: ClassVar[str] = "snapshots with contact, made with --contact lips"

    def __init__(self, tables: ContactTables, geometry: ContactGeometry, carriers: int) -> None:
        self.tables, self.geometry = tables, geometry
        self.fields = np.zeros((0, carriers, 3), np.float32)
        t = tables
        self._turn, self._origin = np.eye(3), np.zeros(3)
        self._teeth = (
            t.points, t.onset, t.away, t.distances, t.starts, t.shapes, t.lows, t.spacings, t.moves,
            self._turn, self._origin,
        )  # fmt: skip
        sign = float(t.orientation[0])
        self._lips = t.vertices, t.facing, t.places, t.triangles, t.across, t.planes, sign
        self._rows = t.row_starts, t.row_controls, t.row_shares
        self._columns = t.column_starts, t.column_vertices, t.column_shares
        points, vertices, controls = len(t.points), len(t.vertices), len(t.column_starts) - 1
        self._all = np.arange(points, dtype=np.int32), np.arange(vertices, dtype=np.int32)
        self._state = (
            t.facing.copy(), np.zeros(points, np.int32), np.zeros(vertices, np.int32), np.zeros(points),
            np.zeros((points, 3)), np.zeros(vertices), np.zeros((vertices, 3)), np.zeros((controls, 3)),
            np.zeros(controls), np.zeros((controls, 3)),
        )  # fmt: skip
        self._motion = np.zeros((4, 4))

    @classmethod
    def train(cls, snapshots: SnapshotSet, fields: FloatArray) -> Contact | None:
        """Return that of snapshots that were solved with contact, else None."""
        if snapshots.contact is None:
            return None
        surface = snapshots.surface
        rest, triangles = surface.points.astype(np.float32), surface.triangles.astype(np.int32)
        tables = contact_tables(snapshots.contact, snapshots.poses, rest, triangles, frames_of(snapshots))
        return cls(tables, snapshots.contact, len(np.unique(surface.weights.indices)))

    def check(self, surroundings: Surroundings) -> None:
        """Nothing: it shows what it can, whatever acts from outside."""

    def drive(self, parameters: FloatArray, surroundings: Surroundings) -> Surroundings:
        """Nothing: contact does not change what muscles do."""
        return surroundings

    def respond(
        self, parameters: FloatArray, coordinates: FloatArray, own: FloatArray, surroundings: Surroundings
    ) -> None:
        """Nothing: it is the vertices that touch."""

    def finish(self, coordinates: FloatArray, vertices: npt.NDArray[np.float32]) -> None:
        """Move vertices (n, 3) out of teeth and lips, in place."""
        transforms = self.tables.transforms
        if len(transforms):
            np.dot(
                coordinates[: len(transforms)], transforms.reshape(len(transforms), 16), out=self._motion.reshape(16)
            )
            self._turn[:] = self._motion[:3, :3]
            self._turn.flat[::4] += 1.0
            self._origin[:] = self._motion[:3, 3]
        resolve(vertices, self._teeth, self._lips, self._rows, self._columns, *self._all, self._state)

    def at(self, setting: Setting) -> Contact:
        """Return the effect with a state of its own; it is the same for any number of modes."""
        return Contact(self.tables, self.geometry, self.fields.shape[1])

    def within(self, part: Part) -> Contact:
        """Return the effect of what a part holds of the lips."""
        return Contact(self.tables.within(part), self.geometry, len(part.carriers))

    def in_axes(self, order: tuple[int, int, int]) -> Contact:
        """Return the effect for vertices whose components are in another order."""
        return Contact(self.tables.in_axes(order), self.geometry, self.fields.shape[1])

    def write(self, group: h5py.Group) -> None:
        """Store tables and geometry."""
        group.attrs["carriers"] = self.fields.shape[1]
        self.geometry.write(group.create_group("geometry"))
        tables = group.create_group("tables")
        for field in fields(self.tables):
            tables[field.name] = getattr(self.tables, field.name)

    @classmethod
    def read(cls, group: h5py.Group) -> Contact:
        """Load what `write` stored."""
        tables = ContactTables(**{field.name: group["tables"][field.name][()] for field in fields(ContactTables)})
        return cls(tables, ContactGeometry.read(group["geometry"]), int(group.attrs["carriers"]))
