"""What candidates are tried on: inputs of the held-out snapshots, and what are like them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius.model import ReducedModel
from risorius.snapshot_file import SnapshotSet

# Of the provenance of snapshots: what may differ between runs that add to one file.
PER_RUN = ("versions", "risorius")
REMEDY = "give the snapshots that the model was trained from with --snapshots"


def require_of_model(snapshots: SnapshotSet, model: ReducedModel, path: Path) -> None:
    """Raise InputError unless the snapshots are of the run that the model was trained from.

    Only then is what is held out known to be new to the model.
    """
    compared = {
        "parameters": (_few(snapshots.inputs.parameters), _few(model.inputs.parameters)),
        **{
            key: (_plain(snapshots.provenance[key]), _plain(model.provenance.get(key)))
            for key in sorted(set(snapshots.provenance) - set(PER_RUN))
        },
        "number of visible vertices": (len(snapshots.surface.points), len(model.rest_vertices)),
    }
    for name, (theirs, ours) in compared.items():
        if theirs != ours:
            raise InputError(f"{path}: its {name}: {theirs}, of the model: {ours}; {REMEDY}")


def frames_like(parameters: FloatArray, lowest: FloatArray, count: int) -> FloatArray:
    """Inputs (count, p) with the patterns of those given (s, p): the same ones act, each by up to 20 % otherwise."""
    rng = np.random.default_rng(0)
    rows = rng.integers(0, len(parameters), count)
    return np.clip(parameters[rows] * rng.uniform(0.8, 1.2, (count, parameters.shape[1])), lowest, 1.0)


def made_up_inputs(model: ReducedModel) -> FloatArray:
    """Parameters (200, p) where the snapshots are absent: one to four act at 0.1 to 1; in every fourth, all muscles."""
    rng = np.random.default_rng(0)
    count = len(model.inputs.parameters)
    inputs = np.zeros((200, count))
    for row in inputs:
        chosen = rng.choice(count, rng.integers(1, min(4, count) + 1), replace=False)
        row[chosen] = rng.uniform(0.1, 1.0, len(chosen))
    strong = inputs[::4, : len(model.inputs.muscles)]
    strong[:] = rng.uniform(0.6, 1.0, strong.shape)
    return inputs


def _few(names: tuple[str, ...]) -> str:
    return f"{len(names)}, {names[0]} ... {names[-1]}"


def _plain(value: object) -> object:
    """Values as JSON gives them back."""
    return list(map(_plain, value)) if isinstance(value, tuple | list) else value
