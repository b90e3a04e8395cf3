"""Snapshots: equilibria of the full model, as the offline part writes them and training reads them."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import h5py
import numpy as np
import numpy.typing as npt

from risorius import storage
from risorius.companion import Companion, read_companions, write_companions
from risorius.contact_geometry import ContactGeometry
from risorius.errors import FileFormatError, InputError
from risorius.inputs import InputTable
from risorius.jaw import FloatArray
from risorius.journalled_file import FileReader
from risorius.mechanics.body import Body
from risorius.mechanics.one_sided import OneSidedSprings
from risorius.poses import Poses
from risorius.surface import CarriedSurface

SCHEMA = "risorius-snapshots"
SCHEMA_VERSION = 6
WAITING, SOLVED, FAILED = 0, 1, 2  # values of samples/state
# Snapshots that are read at once: 100 000 components of 64 of them take 26 MB.
BLOCK = 64


class Rows(Protocol):
    """Arrays of one shape, float32, one for each snapshot: in memory, or read from the file when asked for."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of snapshots, then the shape of one."""
        ...

    def __len__(self) -> int: ...

    def __getitem__(self, rows: Any, /) -> Any:
        """Array of the given rows: a slice, numbers or flags."""
        ...


@dataclass(frozen=True)
class Face:
    """What all snapshots of a file have in common; SI units.

    points (n, 3) nodes at rest; surface that is seen, and companions seen with it; nodal_volumes (n,) cubic metres;
    lift_fields (lifts, n, 3), one for each lift coordinate of the poses. body: of muscles whose active stress is
    proportional to stretch, else None. contact: what skin touches, None where snapshots were solved without contact.
    leaning: (5, n, 3) metres, displacement of the face at rest in each pose of `effects.leaning.LEANING`; None in files
    without derivatives and in older ones. springs: what stops tissue that is pressed from rest; None where contact is,
    and in older files.
    """

    name: str
    muscles: tuple[str, ...]
    poses: Poses
    points: FloatArray
    surface: CarriedSurface
    companions: Mapping[str, Companion]
    nodal_volumes: FloatArray
    lift_fields: FloatArray
    body: Body | None
    contact: ContactGeometry | None
    leaning: FloatArray | None = field(default=None, kw_only=True)
    springs: OneSidedSprings | None = field(default=None, kw_only=True)

    @property
    def inputs(self) -> InputTable:
        """Names of the parameters and of what drives them."""
        return InputTable(self.muscles, self.poses.inputs)

    def write(self, group: h5py.Group) -> None:
        """Store all fields, with their checksum."""
        group.attrs["name"] = self.name
        group.create_dataset("muscles", data=list(self.muscles), dtype=storage.TEXT)
        self.poses.write(group)
        self.surface.write(group.create_group("surface"))
        write_companions(group, self.companions)
        for name in ("points", "nodal_volumes", "lift_fields"):
            group[name] = getattr(self, name)
        if self.body is not None:
            self.body.write(group.create_group("body"))
        if self.contact is not None:
            self.contact.write(group.create_group("contact"))
        if self.leaning is not None:
            group["leaning"] = self.leaning
        if self.springs is not None:
            self.springs.write(group.create_group("springs"))
        group.attrs["sha256"] = storage.content_checksum(group)


@dataclass(frozen=True)
class SnapshotSet(Face):
    """Solved snapshots of one face.

    parameters (s, p); kinds: part of the sampling design, of each snapshot; held_out (s,): never used for training;
    displacements (s, n, 3); derivatives (s, p, n, 3), of the displacements by the parameters, and by_gravity
    (s, 3, n, 3), by m/s2 of gravity, None where they were not kept; smallest_jacobians (s,) over all quadrature points;
    failures: what could not be solved, and why.
    """

    parameters: FloatArray
    kinds: tuple[str, ...]
    held_out: npt.NDArray[np.bool_]
    displacements: Rows
    derivatives: Rows | None
    smallest_jacobians: FloatArray
    failures: tuple[str, ...]
    provenance: Mapping[str, Any]
    by_gravity: Rows | None = None

    @classmethod
    def load(cls, path: str | Path) -> SnapshotSet:
        """Open a snapshot file, also one that is being written: as its last commit left it.

        Displacements and derivatives stay in the file until they are asked for. Raises InputError, FileFormatError.
        """
        path = Path(path)
        with reading(path) as file:
            group, samples = file["face"], file["samples"]
            storage.require_checksum(group, path)
            solved = np.flatnonzero(samples["state"][()] == SOLVED)
            failed = np.flatnonzero(samples["state"][()] == FAILED)
            return cls(
                name=str(group.attrs["name"]),
                muscles=storage.text_list(group["muscles"]),
                poses=Poses.read(group),
                points=group["points"][()],
                surface=CarriedSurface.read(group["surface"]),
                companions=read_companions(group),
                nodal_volumes=group["nodal_volumes"][()],
                lift_fields=group["lift_fields"][()],
                body=Body.read(group["body"]) if "body" in group else None,
                leaning=group["leaning"][()] if "leaning" in group else None,
                springs=OneSidedSprings.read(group["springs"]) if "springs" in group else None,
                contact=ContactGeometry.read(group["contact"]) if "contact" in group else None,
                parameters=samples["parameters"][()][solved],
                kinds=tuple(samples["kind"].asstr()[()][solved]),
                held_out=samples["held_out"][()][solved],
                displacements=StoredRows(path, "displacements", solved, samples["displacements"].shape[1:]),
                derivatives=_rows_where_kept(path, samples, "derivatives", solved),
                by_gravity=_rows_where_kept(path, samples, "by_gravity", solved),
                smallest_jacobians=samples["report"]["smallest_jacobian"][solved],
                failures=tuple(samples["failure"].asstr()[()][failed]),
                provenance=json.loads(file.attrs["provenance"]),
            )

    def single_actions(self) -> npt.NDArray[np.int64]:
        """Number of the snapshot of every single parameter at weight 1; raises InputError where one is missing."""
        rows = []
        for name, wanted in zip(self.inputs.parameters, np.eye(self.parameters.shape[1]), strict=True):
            found = np.flatnonzero((self.parameters == wanted).all(axis=1) & ~self.held_out)
            if not len(found):
                raise InputError(f"snapshots: {name} alone at weight 1 is missing (unsolved?); superposition needs it")
            rows.append(int(found[0]))
        return np.array(rows)


@dataclass(frozen=True)
class StoredRows:
    """Rows of a field of a snapshot file; rows (s,) are the positions there, `each` the shape of one."""

    path: Path
    field: str
    rows: npt.NDArray[np.int64]
    each: tuple[int, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of snapshots, then the shape of one."""
        return (len(self.rows), *self.each)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, rows: Any, /) -> npt.NDArray[np.float32]:
        """Read rows: a number, a slice, numbers or flags. Raises FileFormatError where the file is damaged."""
        wanted = self.rows[rows]
        result = np.empty((wanted.size, *self.each), np.float32)
        with reading(self.path) as file:
            field = file["samples"][self.field]
            for out, row in zip(result, wanted.reshape(-1), strict=True):
                try:
                    field.read_direct(out, np.s_[row])
                except OSError as error:
                    raise FileFormatError(
                        f"{self.path}: {self.field} of snapshot {row} are damaged ({error}); solve the snapshots anew"
                    ) from error
        return result.reshape(*wanted.shape, *self.each)


def _rows_where_kept(path: Path, samples: h5py.Group, field: str, rows: npt.NDArray[np.int64]) -> StoredRows | None:
    return StoredRows(path, field, rows, samples[field].shape[1:]) if field in samples else None


def stored_settings(path: Path) -> Mapping[str, Any]:
    """Return what a run that goes on with a snapshot file has to know. Raises InputError, FileFormatError."""
    with reading(path) as file:
        return dict(json.loads(file.attrs["settings"]))


def solve_seconds(path: Path) -> FloatArray:
    """CPU seconds (s,) that each of the solved snapshots of a file took. Raises InputError, FileFormatError."""
    with reading(path) as file:
        samples = file["samples"]
        return np.asarray(samples["report"]["seconds"][samples["state"][()] == SOLVED])


@contextmanager
def reading(path: Path) -> Iterator[h5py.File]:
    """Open a snapshot file for reading, as its last commit left it.

    Raises InputError when there is none, FileFormatError when it is truncated, damaged, foreign or of another version.
    """
    storage.require_file(path)
    with closing(FileReader(path)) as view, storage.opened(path, view, "r") as file:
        storage.require_header(file, path, SCHEMA, SCHEMA_VERSION)
        yield file
