"""Snapshots: equilibria of the full model, as the offline part writes them and training reads them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from risorius import storage
from risorius.inputs import InputTable
from risorius.jaw import FloatArray
from risorius.poses import Poses

SCHEMA = "risorius-snapshots"
SCHEMA_VERSION = 3
PER_SAMPLE = ("displacements", "derivatives")  # stored in one compressed chunk a field


@dataclass(frozen=True)
class SnapshotSet:
    """Solved snapshots of one anatomy; SI units.

    points (n, 3) nodes at rest; skin (m, 3) triangles of node numbers; nodal_volumes (n,) cubic metres; lift_fields
    (lifts, n, 3), one for each lift coordinate of the poses; parameters (s, p); displacements (s, n, 3) float32;
    derivatives (s, p, n, 3) float32, of the displacements by the parameters; held_out (s,): never used for training;
    smallest_jacobians (s,) over all quadrature points; failures: what could not be solved, and why.
    """

    name: str
    muscles: tuple[str, ...]
    poses: Poses
    points: FloatArray
    skin: npt.NDArray[np.int64]
    nodal_volumes: FloatArray
    lift_fields: FloatArray
    parameters: FloatArray
    displacements: npt.NDArray[np.float32]
    derivatives: npt.NDArray[np.float32]
    held_out: npt.NDArray[np.bool_]
    smallest_jacobians: FloatArray
    failures: tuple[str, ...]
    provenance: Mapping[str, Any]

    _ARRAYS = (
        "points",
        "skin",
        "nodal_volumes",
        "lift_fields",
        "parameters",
        "displacements",
        "derivatives",
        "held_out",
        "smallest_jacobians",
    )

    @property
    def inputs(self) -> InputTable:
        """Names of the parameters and of what drives them."""
        return InputTable(self.muscles, self.poses.inputs)

    def save(self, path: str | Path) -> None:
        """Write the snapshot file; it appears under its name only when complete."""
        with storage.writing(Path(path), SCHEMA, SCHEMA_VERSION) as file:
            file.attrs["name"] = self.name
            file.attrs["provenance"] = json.dumps(dict(self.provenance), sort_keys=True)
            file.create_dataset("muscles", data=list(self.muscles), dtype=storage.TEXT)
            file.create_dataset("failures", data=list(self.failures), dtype=storage.TEXT)
            self.poses.write(file)
            for name in self._ARRAYS:
                values = getattr(self, name)
                if name not in PER_SAMPLE:
                    file[name] = values
                    continue
                chunk = (*np.ones(values.ndim - 2, int), *values.shape[-2:])
                file.create_dataset(
                    name, data=values, chunks=chunk, compression="gzip", compression_opts=1, shuffle=True
                )

    @classmethod
    def load(cls, path: str | Path) -> SnapshotSet:
        """Read a snapshot file; raises InputError or FileFormatError."""
        with storage.reading(Path(path), SCHEMA, SCHEMA_VERSION) as file:
            return cls(
                name=str(file.attrs["name"]),
                muscles=storage.text_list(file["muscles"]),
                poses=Poses.read(file),
                failures=storage.text_list(file["failures"]),
                provenance=json.loads(file.attrs["provenance"]),
                **{name: file[name][()] for name in cls._ARRAYS},
            )
