"""What candidates are tried on: held-out snapshots, ordinary and strong ones apart."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius.model import ReducedModel
from risorius.snapshot_file import SnapshotSet

ORDINARY, STRONG = "ordinary", "strong"
# Of the provenance of snapshots: what may differ between runs that add to one file.
PER_RUN = ("versions", "risorius")


@dataclass(frozen=True)
class HeldOutSet:
    """Snapshots of one kind: parameters (s, p) and vertices (s, n, 3) of the full model, metres."""

    name: str
    parameters: FloatArray
    vertices: npt.NDArray[np.float32]


def held_out_sets(snapshots: SnapshotSet) -> list[HeldOutSet]:
    """Held-out snapshots by kind, in the order of their first appearance. Raises InputError when there is none."""
    rows = np.flatnonzero(snapshots.held_out)
    if not len(rows):
        raise InputError("snapshots: none is held out, errors cannot be measured; solve some with --held-out")
    kinds = np.array(snapshots.kinds)[rows]
    return [_set_of(snapshots, kind, rows[kinds == kind]) for kind in dict.fromkeys(map(str, kinds))]


def _set_of(snapshots: SnapshotSet, kind: str, rows: npt.NDArray[np.int64]) -> HeldOutSet:
    surface = snapshots.surface
    vertices = np.empty((len(rows), *surface.points.shape), np.float32)
    for out, row in zip(vertices, rows, strict=True):
        out[:] = surface.points + surface.weights @ snapshots.displacements[row].astype(np.float64)
    return HeldOutSet(kind, snapshots.parameters[rows], vertices)


def require_of_model(snapshots: SnapshotSet, model: ReducedModel, path: Path) -> None:
    """Raise InputError unless the snapshots are of the run that the model was trained from.

    Only then is what is held out known to be new to the model.
    """
    if snapshots.inputs.parameters != model.inputs.parameters:
        raise InputError(
            f"{path}: has {len(snapshots.inputs.parameters)} parameters, {snapshots.inputs.parameters[0]} ..., "
            f"the model {len(model.inputs.parameters)}, {model.inputs.parameters[0]} ...; "
            "give the snapshots that the model was trained from with --snapshots"
        )
    for key in sorted(set(snapshots.provenance) - set(PER_RUN)):
        if _plain(snapshots.provenance[key]) != _plain(model.provenance.get(key)):
            raise InputError(
                f"{path}: {key} is {snapshots.provenance[key]!r}, that of the model {model.provenance.get(key)!r}; "
                "give the snapshots that the model was trained from with --snapshots"
            )
    if snapshots.surface.points.shape != model.rest_vertices.shape:
        raise InputError(
            f"{path}: shows {len(snapshots.surface.points)} vertices, the model {len(model.rest_vertices)}; "
            "give the snapshots that the model was trained from with --snapshots"
        )


def made_up_inputs(model: ReducedModel, seed: int = 0) -> dict[str, FloatArray]:
    """Parameters (200, p) like those held out, where the snapshots are absent.

    Ordinary: up to four at 0.1 to 1. Strong: all muscles at 0.6 to 1.
    """
    rng = np.random.default_rng(seed)
    count, muscles = len(model.inputs.parameters), len(model.inputs.muscles)
    ordinary, strong = np.zeros((200, count)), np.zeros((200, count))
    for row in ordinary:
        chosen = rng.choice(count, rng.integers(1, min(4, count) + 1), replace=False)
        row[chosen] = rng.uniform(0.1, 1.0, len(chosen))
    strong[:, :muscles] = rng.uniform(0.6, 1.0, (200, muscles))
    return {ORDINARY: ordinary, STRONG: strong}


def _plain(value: object) -> object:
    """Values as JSON gives them back."""
    return list(map(_plain, value)) if isinstance(value, tuple | list) else value
