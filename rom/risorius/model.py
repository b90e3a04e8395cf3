"""The reduced model and its file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from risorius import storage
from risorius.carried_basis import CarriedBasis
from risorius.companion import Companion, read_companions, write_companions
from risorius.effects import EFFECTS, Effect
from risorius.errors import FileFormatError
from risorius.evaluators import EVALUATORS, Evaluator
from risorius.guard import Watch
from risorius.inputs import InputTable
from risorius.operating_point import OperatingPoint
from risorius.poses import Poses
from risorius.surface import NO_COLOURS, Colours

SCHEMA = "risorius-model"
SCHEMA_VERSION = 10


@dataclass(frozen=True)
class ReducedModel:
    """Visible vertices x = rest + sum_k q_k basis_k, and evaluators that give the modal part of q.

    rest_vertices: (n, 3) float32, metres. triangles: (m, 3) int32, outward. carried_basis: its first `lifts` fields
    carry the unit motions of the poses into the skin and are driven exactly. points: measured ways of running it.
    colours: (n, 3) sRGB or NO_COLOURS. companions: rigid things seen with the face, by name; `Companion.posed` moves
    them by the coordinates of a frame. effects: those that a scene may ask for, by name. watch: where its tissue folds
    first; None for snapshots without a body.
    """

    name: str
    inputs: InputTable
    poses: Poses
    rest_vertices: npt.NDArray[np.float32]
    triangles: npt.NDArray[np.int32]
    carried_basis: CarriedBasis
    evaluators: Mapping[str, Evaluator]
    points: tuple[OperatingPoint, ...]
    provenance: Mapping[str, Any]
    colours: Colours = field(default_factory=NO_COLOURS.copy)
    companions: Mapping[str, Companion] = field(default_factory=dict)
    effects: Mapping[str, Effect] = field(default_factory=dict)
    watch: Watch | None = None

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

    def in_axes(self, order: tuple[int, int, int]) -> ReducedModel:
        """Return the model whose vertices have their components in another order, so that no frame has to be turned.

        Forces, gravity and companions stay in the frame of the head.
        """
        return replace(
            self,
            rest_vertices=np.ascontiguousarray(self.rest_vertices[:, list(order)]),
            carried_basis=self.carried_basis.in_axes(order),
            effects={name: effect.in_axes(order) for name, effect in self.effects.items()},
            watch=None if self.watch is None else self.watch.in_axes(order),
        )

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
                evaluator.write(file.create_group(f"evaluators/{name}"))
            for name, effect in self.effects.items():
                effect.write(file.create_group(f"effects/{name}"))
            if self.watch is not None:
                self.watch.write(file.create_group("watch"))
            for number, point in enumerate(self.points):
                point.write(file.create_group(f"points/{number:03}"))


def load(path: str | Path) -> ReducedModel:
    """Load a model file after checking schema, units and checksum; nothing in it is executed.

    Raises InputError when there is no such file, FileFormatError when it is not a whole model of this release.
    """
    with storage.reading(Path(path), SCHEMA, SCHEMA_VERSION) as file:
        return _read(file, Path(path))


def _read(file: h5py.File, path: Path) -> ReducedModel:
    poses = Poses.read(file)
    for kind, known in (("evaluators", EVALUATORS), ("effects", EFFECTS)):
        unknown = set(file.get(kind, ())) - set(known)
        if unknown:
            raise FileFormatError(f"{path}: unknown {kind} {sorted(unknown)}; make the file anew with this release")
    stored = file.get("effects", {})
    model = ReducedModel(
        name=str(file.attrs["name"]),
        inputs=InputTable(storage.text_list(file["muscles"]), poses.inputs),
        poses=poses,
        rest_vertices=file["rest_vertices"][()],
        triangles=file["triangles"][()],
        carried_basis=CarriedBasis.read(file["basis"]),
        evaluators={name: EVALUATORS[name].read(group) for name, group in file["evaluators"].items()},
        points=tuple(OperatingPoint.read(group) for _, group in sorted(file["points"].items())),
        provenance=json.loads(file.attrs["provenance"]),
        colours=file["colours"][()],
        companions=read_companions(file),
        effects={name: EFFECTS[name].read(group) for name, group in stored.items()},
        watch=Watch.read(file["watch"]) if "watch" in file else None,
    )
    return model
