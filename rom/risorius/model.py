"""The reduced model and its file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from risorius import storage
from risorius.carried_basis import CarriedBasis
from risorius.companion import Companion, read_companions, write_companions
from risorius.errors import FileFormatError
from risorius.evaluators import EVALUATORS, Evaluator
from risorius.inputs import InputTable
from risorius.poses import Poses
from risorius.surface import NO_COLOURS, Colours

SCHEMA = "risorius-model"
SCHEMA_VERSION = 4


@dataclass(frozen=True)
class Accuracy:
    """Errors over the vertices of held-out snapshots against the full model, metres; `relative` is L2.

    error_floor, error_slope: the per-frame bound is error_floor + error_slope * |nonlinear part of q|; it covers
    `coverage` of the held-out snapshots.
    """

    mean: float
    p95: float
    maximum: float
    relative: float
    error_floor: float
    error_slope: float
    coverage: float


@dataclass(frozen=True)
class ReducedModel:
    """Visible vertices x = rest + sum_k q_k basis_k, and evaluators that give the modal part of q.

    rest_vertices: (n, 3) float32, metres. triangles: (m, 3) int32, outward. carried_basis: its first `lifts` fields
    carry the unit motions of the poses into the skin and are driven exactly.
    colours: (n, 3) sRGB or NO_COLOURS. companions: rigid things seen with the face, by name; `Companion.posed` moves
    them by the coordinates of a frame.
    """

    name: str
    inputs: InputTable
    poses: Poses
    rest_vertices: npt.NDArray[np.float32]
    triangles: npt.NDArray[np.int32]
    carried_basis: CarriedBasis
    evaluators: Mapping[str, Evaluator]
    accuracy: Mapping[str, Accuracy]
    provenance: Mapping[str, Any]
    colours: Colours = field(default_factory=NO_COLOURS.copy)
    companions: Mapping[str, Companion] = field(default_factory=dict)

    @property
    def basis(self) -> npt.NDArray[np.float32]:
        """(r, n, 3), metres per unit coordinate; put together anew at every call."""
        return self.carried_basis.at_vertices()

    @property
    def rank(self) -> int:
        """Number r of reduced coordinates."""
        return len(self.carried_basis)

    @property
    def lifts(self) -> int:
        """Number of leading basis fields that are driven by jaw and lids, exactly."""
        return self.poses.lift_count

    def save(self, path: str | Path) -> None:
        """Write the model file; it appears under its name only when complete."""
        with storage.writing(Path(path), SCHEMA, SCHEMA_VERSION) as file:
            file.attrs["name"] = self.name
            file.attrs["provenance"] = json.dumps(self.provenance, sort_keys=True)
            file.create_dataset("muscles", data=list(self.inputs.muscles), dtype=storage.TEXT)
            self.poses.write(file)
            file["rest_vertices"] = self.rest_vertices
            file["triangles"] = self.triangles
            file["colours"] = self.colours
            write_companions(file, self.companions)
            self.carried_basis.write(file.create_group("basis"))
            for name, evaluator in self.evaluators.items():
                group = file.create_group(f"evaluators/{name}")
                evaluator.write(group)
                group.attrs.update(asdict(self.accuracy[name]))


def load(path: str | Path) -> ReducedModel:
    """Load a model file after checking schema, units and checksum; nothing in it is executed.

    Raises InputError when there is no such file, FileFormatError when it is not a whole model of this release.
    """
    with storage.reading(Path(path), SCHEMA, SCHEMA_VERSION) as file:
        return _read(file, Path(path))


def _read(file: h5py.File, path: Path) -> ReducedModel:
    poses = Poses.read(file)
    unknown = set(file["evaluators"]) - set(EVALUATORS)
    if unknown:
        raise FileFormatError(f"{path}: unknown evaluator {sorted(unknown)}; make the file anew with this release")
    groups = dict(file["evaluators"].items())
    model = ReducedModel(
        name=str(file.attrs["name"]),
        inputs=InputTable(storage.text_list(file["muscles"]), poses.inputs),
        poses=poses,
        rest_vertices=file["rest_vertices"][()],
        triangles=file["triangles"][()],
        carried_basis=CarriedBasis.read(file["basis"]),
        evaluators={name: EVALUATORS[name].read(group) for name, group in groups.items()},
        accuracy={name: Accuracy(**storage.plain_attributes(group)) for name, group in groups.items()},
        provenance=json.loads(file.attrs["provenance"]),
        colours=file["colours"][()],
        companions=read_companions(file),
    )
    return model
