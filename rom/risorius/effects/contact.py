"""Contact: skin that the map has put into teeth, or a lip that it has put into the other, is moved out of there.

The map was trained with contact and knows of most of it. What is left is found at a few hundred points of the skin and
pushed out along smooth fields around them, at most `SWEEPS` times in a frame, all in place.
"""

from __future__ import annotations

from dataclasses import fields
from typing import Any, ClassVar

import h5py
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from risorius.contact_geometry import ContactGeometry
from risorius.effects.contact_kernels import resolve
from risorius.effects.contact_patches import Patches
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
    energy: ClassVar[float] = 0.0

    def __init__(self, tables: ContactTables, geometry: ContactGeometry, carriers: int) -> None:
        self.tables, self.geometry = tables, geometry
        self.fields = np.zeros((0, carriers, 3), np.float32)
        t = tables
        self._turn, self._origin = np.eye(3), np.zeros(3)
        self._teeth = (
            t.points, t.onset, t.away, t.distances, t.starts, t.shapes, t.lows, t.spacings, t.moves,
            self._turn, self._origin,
        )  # fmt: skip
        self._rows = t.row_starts, t.row_controls, t.row_shares
        self._columns = t.column_starts, t.column_vertices, t.column_shares
        points, vertices, controls = len(t.points), len(t.vertices), len(t.column_starts) - 1
        rows = sp.csr_matrix((t.row_shares, t.row_controls, t.row_starts), shape=(len(t.row_starts) - 1, controls))
        touching = t.onset > -1.0
        kinds = np.unique(touching, axis=0, return_inverse=True)[1].ravel()
        slack = -np.where(touching, t.onset, 0.0).min(axis=1, initial=0.0)
        of_lips = Patches.of(rows[t.vertices], np.zeros(vertices, np.int64))
        self._patches = _tables(Patches.of(rows[t.points], kinds), slack), _tables(of_lips, np.zeros(vertices))
        beside = sp.csr_matrix(rows.T @ rows)
        movers = np.where(np.diff(t.row_starts) > 0, np.append(t.row_controls, -1)[t.row_starts[:-1]], -1)
        self._opposite = (
            movers[t.triangles[:, 0]].astype(np.int32), beside.indptr.astype(np.int32),
            beside.indices.astype(np.int32), np.zeros(controls),
        )  # fmt: skip
        sign = float(t.orientation[0])
        self._lips = t.vertices, t.facing, t.places, t.triangles, t.across, t.planes, sign
        self._state = (
            t.facing.copy(), np.zeros(points, np.int32), np.zeros(vertices, np.int32), np.zeros(points),
            np.zeros((points, 3)), np.zeros(vertices), np.zeros((vertices, 3)), np.zeros((controls, 3)),
            np.zeros(controls), np.zeros((controls, 3)), np.zeros(controls),
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
        resolve(
            vertices, self._teeth, self._lips, self._rows, self._columns, *self._patches, self._opposite, self._state
        )

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


def _tables(patches: Patches, slack: FloatArray) -> tuple[npt.NDArray[Any], ...]:
    return patches.leaders, slack, patches.order, patches.starts, patches.control_starts, patches.controls
