"""The snapshot file as it is filled: samples are added to it first, and solved, or given up, one by one.

The file is also the plan of the run: what is waiting in it is left to do. Every change is one commit of a journalled
file, so that a run that ends, however it ends, loses nothing that was recorded.
"""

from __future__ import annotations

import json
import signal
import threading
import uuid
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from risorius import storage
from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius.journalled_file import IDENTITY_BYTES, FileWriter
from risorius.packing import packed, rows_of_chunks, write_packed
from risorius.poses import Poses
from risorius.snapshot_file import FAILED, SCHEMA, SCHEMA_VERSION, SOLVED, WAITING, Face, reading

USER_BLOCK = 512
KIND = np.dtype("S16")
REPORT = np.dtype(
    [
        ("attempts", "i4"),
        ("iterations", "i4"),
        ("factorisations", "i4"),
        ("projections", "i4"),
        ("steps", "i4"),
        ("rejected_steps", "i4"),
        ("stable", "?"),
        ("smallest_jacobian", "f8"),
        ("energy", "f8"),
        ("residual", "f8"),
        ("seconds", "f8"),
    ]
)
"""What a solve took, as in the solver's report: counts, smallest J, joules, relative residual, CPU seconds."""


@dataclass(frozen=True)
class Samples:
    """Parameters (s, p) to solve; kinds: part of the design; held_out (s,); paths (s,): number of the path of each."""

    parameters: FloatArray
    kinds: Sequence[str]
    held_out: npt.NDArray[np.bool_]
    paths: npt.NDArray[np.int64]


@dataclass(frozen=True)
class Solved:
    """Result of one sample: displacement (n, 3), and all that the file is to keep of it, packed, by field."""

    displacement: npt.NDArray[np.float32]
    fields: Mapping[str, bytes]
    report: Mapping[str, float]

    @classmethod
    def of(cls, displacement: FloatArray, slopes: Mapping[str, FloatArray], report: Mapping[str, float]) -> Solved:
        """Pack a displacement (n, 3) and, where they are kept, its derivatives: (p, n, 3), by_gravity: (3, n, 3)."""
        single = displacement.astype(np.float32)
        fields = {"displacements": single, **{name: values.astype(np.float32) for name, values in slopes.items()}}
        return cls(single, {name: packed(values) for name, values in fields.items()}, report)


class SnapshotStore:
    """The one writer of a snapshot file; use `opened`."""

    def __init__(self, path: Path, view: FileWriter, file: h5py.File) -> None:
        self.path = path
        self._view, self._file, self._samples = view, file, file["samples"]
        self.settings: Mapping[str, Any] = json.loads(file.attrs["settings"])
        self.provenance: Mapping[str, Any] = json.loads(file.attrs["provenance"])
        self._muscle_count, self._poses = len(file["face/muscles"]), Poses.read(file["face"])
        self._lift_fields: FloatArray = file["face/lift_fields"][()]
        self.parameters: FloatArray = self._samples["parameters"][()]
        self.kinds: npt.NDArray[np.bytes_] = self._samples["kind"][()]
        self.held_out: npt.NDArray[np.bool_] = self._samples["held_out"][()]
        self.paths: npt.NDArray[np.int64] = self._samples["path"][()]
        self.states: npt.NDArray[np.uint8] = self._samples["state"][()]

    def add(self, samples: Samples) -> None:
        """Add samples, waiting to be solved."""
        start, count = len(self.parameters), len(self.parameters) + len(samples.parameters)
        for field in self._samples.values():
            field.resize(count, axis=0)
        fields = {"parameters": samples.parameters, "kind": np.array(samples.kinds, KIND),
                  "held_out": samples.held_out, "path": samples.paths}  # fmt: skip
        for name, values in fields.items():
            self._samples[name][start:] = values
        self._commit()
        self.parameters = np.concatenate([self.parameters, samples.parameters])
        self.kinds = np.concatenate([self.kinds, fields["kind"]])
        self.held_out = np.concatenate([self.held_out, samples.held_out])
        self.paths = np.concatenate([self.paths, samples.paths])
        self.states = np.concatenate([self.states, np.full(count - start, WAITING, np.uint8)])

    def record(self, row: int, solved: Solved) -> None:
        """Store the result of a sample. Raises Error when the disk is full; the file stays as it was."""
        with _uninterrupted():
            for name in solved.fields.keys() & self._samples.keys():  # a file may keep less
                write_packed(self._samples[name], row, solved.fields[name])
            self._finish(row, SOLVED, solved.report)

    def give_up(self, row: int, reason: str, report: Mapping[str, float]) -> None:
        """Store why a sample has no result."""
        with _uninterrupted():
            self._samples["failure"][row] = reason
            self._finish(row, FAILED, report)

    def displacement(self, row: int) -> npt.NDArray[np.float32]:
        """Stored displacement (n, 3) of a solved sample."""
        return np.asarray(self._samples["displacements"][row])

    def following(self, parameters: FloatArray) -> FloatArray:
        """Displacement (n, 3) with which tissue follows the bones and lids at parameters (p,), to first order."""
        lifts = self._poses.lift_coordinates(parameters[self._muscle_count :])
        return np.tensordot(lifts, self._lift_fields, axes=1)

    def failures(self) -> list[str]:
        """Why samples were given up."""
        return [str(text) for text in self._samples["failure"].asstr()[()][self.states == FAILED]]

    def remember(self, settings: Mapping[str, Any], provenance: Mapping[str, Any]) -> None:
        """Store what the run was asked for, and what it runs with."""
        self._file.attrs["settings"] = json.dumps(dict(settings), sort_keys=True)
        self._file.attrs["provenance"] = json.dumps(dict(provenance), sort_keys=True)
        self._commit()
        self.settings, self.provenance = dict(settings), dict(provenance)

    def _finish(self, row: int, state: int, report: Mapping[str, float]) -> None:
        entry = np.zeros((), REPORT)
        for name, value in report.items():
            entry[name] = value
        self._samples["report"][row] = entry
        self._samples["state"][row] = state
        self._commit()
        self.states[row] = state

    def _commit(self) -> None:
        self._file.flush()
        self._view.commit()


def create(
    path: Path, face: Face, settings: Mapping[str, Any], provenance: Mapping[str, Any], *, derivatives: bool
) -> None:
    """Make an empty snapshot file. Raises InputError when there is something under its name: it is never replaced."""
    if path.exists():
        raise InputError(f"{path}: exists already; choose another output or remove it")
    with storage.replaced_when_complete(path) as partial:
        with h5py.File(partial, "w", userblock_size=USER_BLOCK) as file:
            storage.write_header(file, SCHEMA, SCHEMA_VERSION)
            file.attrs["settings"] = json.dumps(dict(settings), sort_keys=True)
            file.attrs["provenance"] = json.dumps(dict(provenance), sort_keys=True)
            face.write(file.create_group("face"))
            _create_fields(file.create_group("samples"), face, derivatives)
        with partial.open("r+b") as raw:
            raw.write(f"{SCHEMA} {uuid.uuid4()}\n".encode().ljust(IDENTITY_BYTES, b"\n"))


def _create_fields(group: h5py.Group, face: Face, derivatives: bool) -> None:
    count, nodes = len(face.inputs.parameters), face.points.shape
    small: dict[str, tuple[tuple[int, ...], Any, int]] = {
        "parameters": ((count,), np.float64, 32),
        "kind": ((), KIND, 256),
        "held_out": ((), np.bool_, 1024),
        "path": ((), np.int64, 256),
        "state": ((), np.uint8, 1024),
        "report": ((), REPORT, 64),
        "failure": ((), storage.TEXT, 64),
    }
    for name, (shape, dtype, rows) in small.items():
        group.create_dataset(name, (0, *shape), dtype, maxshape=(None, *shape), chunks=(rows, *shape))
    # One chunk for each snapshot: it is written once and read whole.
    slopes = {"derivatives": (count, *nodes), "by_gravity": (3, *nodes)} if derivatives else {}
    fields = {"displacements": nodes, **slopes}
    for name, each in fields.items():
        rows_of_chunks(group, name, each)


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Put off Ctrl-C: an exception inside HDF5's calls to our file would be lost, or leave HDF5 in disorder."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    interrupts: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: interrupts.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if interrupts:
        raise KeyboardInterrupt


@contextmanager
def opened(path: Path) -> Iterator[SnapshotStore]:
    """Open a snapshot file to go on with it.

    Raises InputError when another run is writing it, FileFormatError when it is not a whole file of this release;
    such a file is left as it is.
    """
    with reading(path) as file:  # a foreign file is not even given a journal
        storage.require_checksum(file["face"], path)
    with closing(FileWriter(path)) as view, h5py.File(view, "r+") as file:
        yield SnapshotStore(path, view, file)
