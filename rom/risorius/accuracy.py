"""How far a reduced model is off: on held-out snapshots, over the visible vertices, by kind of input."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius.snapshot_file import SnapshotSet

COVERAGE = 0.95


@dataclass(frozen=True)
class Errors:
    """Distances of the visible vertices of held-out snapshots to the full model, metres.

    mean, p95, maximum: over all vertices of all of them. frame: on COVERAGE of frames no vertex is further off.
    relative: median L2. count: of snapshots.
    """

    mean: float
    p95: float
    maximum: float
    frame: float
    relative: float
    count: int


@dataclass(frozen=True)
class HeldOut:
    """Held-out snapshots as they are seen.

    parameters (h, p); lifts (h, l) coordinates of the poses; kinds of the h; displacements (h, v, 3) of the visible
    vertices in the full model.
    """

    parameters: FloatArray
    lifts: FloatArray
    kinds: tuple[str, ...]
    displacements: npt.NDArray[np.float32]

    @classmethod
    def of(cls, snapshots: SnapshotSet) -> HeldOut:
        """Those of a set. Raises InputError when there is none."""
        rows = np.flatnonzero(snapshots.held_out)
        if not len(rows):
            raise InputError("snapshots: none is held out, the model's accuracy cannot be measured; solve some")
        parameters = snapshots.parameters[rows]
        poses = parameters[:, len(snapshots.muscles) :]
        seen = np.empty((len(rows), *snapshots.surface.points.shape), np.float32)
        for field, row in zip(seen, rows, strict=True):
            field[:] = snapshots.surface.weights @ snapshots.displacements[row].astype(np.float64)
        return cls(
            parameters=parameters,
            lifts=np.stack([snapshots.poses.lift_coordinates(weights) for weights in poses]),
            kinds=tuple(snapshots.kinds[row] for row in rows),
            displacements=seen,
        )

    def errors(self, displacements: Iterable[npt.NDArray[np.floating]]) -> npt.NDArray[np.float32]:
        """Distances (h, v), metres, of answers (v, 3), one for each snapshot, to the full model."""
        result = np.empty(self.displacements.shape[:2], np.float32)
        for row, answer, truth in zip(result, displacements, self.displacements, strict=True):
            row[:] = np.linalg.norm(answer - truth, axis=1)
        return result

    def by_kind(self, errors: npt.NDArray[np.float32]) -> Mapping[str, Errors]:
        """Summaries of distances (h, v) for each kind."""
        kinds = np.array(self.kinds)
        return {kind: self._summary(errors, kinds == kind) for kind in dict.fromkeys(self.kinds)}

    def overall(self, errors: npt.NDArray[np.float32]) -> Errors:
        """Summary of distances (h, v) of all kinds together."""
        return self._summary(errors, np.ones(len(errors), bool))

    def _summary(self, errors: npt.NDArray[np.float32], rows: npt.NDArray[np.bool_]) -> Errors:
        distances, truth = errors[rows].astype(np.float64), self.displacements[rows].astype(np.float64)
        sizes = np.linalg.norm(truth.reshape(len(truth), -1), axis=1)
        relative = np.linalg.norm(distances, axis=1) / np.maximum(sizes, np.finfo(float).tiny)
        return Errors(
            mean=float(distances.mean()),
            p95=float(np.quantile(distances, 0.95)),
            maximum=float(distances.max()),
            frame=conformal_quantile(distances.max(axis=1)),
            relative=float(np.median(relative)),
            count=len(distances),
        )


def conformal_quantile(scores: FloatArray) -> float:
    """Smallest score that covers a new one with probability COVERAGE, given exchangeable scores (Vovk et al. 2005).

    With fewer than 19 it is the largest, which covers less.
    """
    position = int(np.ceil((len(scores) + 1) * COVERAGE))
    return float(np.sort(scores)[min(position, len(scores)) - 1])
