"""From a model, and its snapshots where they are at hand, to results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from risorius.accuracy import Errors, HeldOut
from risorius.jaw import FloatArray
from risorius.model import ReducedModel
from risorius.report.candidates import Candidate, OfflineCost, candidates_of
from risorius.report.continued import continued
from risorius.report.full_model import FullModelRun, FullModelTime, full_model_of, measured_time, stored_time
from risorius.report.held_out import frames_like, made_up_inputs, require_of_model
from risorius.report.machine import load, machine
from risorius.report.measuring import Times, in_turn
from risorius.report.results import Results, Row
from risorius.snapshot_file import SnapshotSet, solve_seconds

FRAMES = 2000
UNKNOWN = OfflineCost(None, None, None)


@dataclass(frozen=True)
class Tried:
    """A snapshot file, checked to be that of the model, its snapshots, and the held-out ones as they are seen."""

    path: Path
    snapshots: SnapshotSet
    held_out: HeldOut

    @classmethod
    def of(cls, path: Path, model: ReducedModel) -> Tried:
        """Raises InputError for a file that is not the model's, or with nothing held out; FileFormatError."""
        snapshots = SnapshotSet.load(path)
        require_of_model(snapshots, model, path)
        return cls(path, snapshots, HeldOut.of(snapshots))

    def inputs(self) -> dict[str, FloatArray]:
        """Parameters (s, p) of each kind that is held out."""
        kinds = np.array(self.held_out.kinds)
        return {kind: self.held_out.parameters[kinds == kind] for kind in dict.fromkeys(self.held_out.kinds)}


def measure(
    model: ReducedModel, tried: Tried, anatomy: str | None = None, peers: Sequence[Candidate] = (), frames: int = FRAMES
) -> Results:
    """Errors on the held-out snapshots and times of all candidates.

    anatomy: source to solve the full model with, from rest and from the map's answers.
    """
    before, inputs = load(), tried.inputs()
    run = None if anatomy is None else full_model_of(anatomy, tried.snapshots.provenance)
    candidates = [*candidates_of(model, *_offline_costs(model, tried)), *peers]
    errors = {one.name: _errors(one, model, tried.held_out) for one in candidates}
    times = {kind: _times(candidates, model, rows, frames) for kind, rows in inputs.items()}
    rows = [
        Row(one.name, one.method, one.family, kind, errors[one.name][kind], *times[kind][one.name], one.offline)
        for kind in inputs
        for one in candidates
    ]
    later, continued_from = _continued(model, tried, run)
    return Results(
        model=model.name,
        rank=model.rank,
        vertices=len(model.rest_vertices),
        rows=(*rows, *later),
        full=_full_model(tried, run, inputs),
        frames=frames,
        errors_from=f"measured in this run on {len(tried.held_out.kinds)} held-out snapshots of {tried.path.name}",
        times_from="inputs with the patterns of the held-out ones, each weight changed by up to 20 %",
        continued_from=continued_from,
        peers=bool(peers),
        machine=machine(before),
    )


def measure_times(model: ReducedModel, frames: int = FRAMES) -> Results:
    """The errors that the model file remembers, and times measured now: where the snapshots are absent."""
    before, stored = load(), {str(point.setting): point.errors for point in model.points}
    candidates = candidates_of(model, UNKNOWN, UNKNOWN)
    times = _times(candidates, model, made_up_inputs(model), frames)
    return Results(
        model=model.name,
        rank=model.rank,
        vertices=len(model.rest_vertices),
        rows=tuple(
            Row(one.name, one.method, one.family, kind, errors, *times[one.name], one.offline)
            for one in candidates
            for kind, errors in stored[one.name].items()
        ),
        full={},
        frames=frames,
        errors_from="not measured in this run: as training stored them in the model file",
        continued_from="not measured: the snapshots were not at hand",
        times_from="made-up inputs, three of four with one to four parameters at work, the others with all muscles",
        peers=False,
        machine=machine(before),
    )


def _errors(candidate: Candidate, model: ReducedModel, held_out: HeldOut) -> Mapping[str, Errors]:
    rest = model.rest_vertices.astype(np.float64)
    answers = (candidate.vertices(parameters) - rest for parameters in held_out.parameters)
    return held_out.by_kind(held_out.errors(answers))


def _times(
    candidates: Sequence[Candidate], model: ReducedModel, like: FloatArray, frames: int
) -> dict[str, tuple[Times, Times]]:
    """Times to coordinates and of the whole frame."""
    inputs = frames_like(like, model.inputs.parameter_lower, frames)
    actions = {f"{one.name} coordinates": one.coordinates for one in candidates}
    actions |= {f"{one.name} frame": one.vertices for one in candidates}
    found = in_turn(actions, inputs)
    return {one.name: (found[f"{one.name} coordinates"], found[f"{one.name} frame"]) for one in candidates}


def _offline_costs(model: ReducedModel, tried: Tried) -> tuple[OfflineCost, OfflineCost]:
    """Of the model, and of superposition, which needs no more than the single actions."""
    seconds, trained = solve_seconds(tried.path), model.provenance.get("snapshots")
    used, singles = seconds[~tried.snapshots.held_out], seconds[tried.snapshots.single_actions()]
    return (
        OfflineCost(
            trained, None if _grown(model, tried) else float(used.sum()), model.provenance.get("training_cpu_seconds")
        ),
        OfflineCost(len(singles), float(singles.sum()), None),
    )


def _continued(model: ReducedModel, tried: Tried, run: FullModelRun | None) -> tuple[list[Row], str]:
    """Rows of the full model that goes on from the map's answers, and where they come from, in words."""
    if run is None:
        return [], "not measured in this run, which was not given the anatomy"
    if _grown(model, tried):
        return [], "not measured: there are more snapshots than the model was trained from"
    rows = list(continued(model, tried.snapshots, tried.held_out, run))
    return rows, "measured in this run: every held-out snapshot once, by the clock, nodal displacements to their like"


def _grown(model: ReducedModel, tried: Tried) -> bool:
    """Whether there are more snapshots than the model was trained from: which of them it knew is not recorded."""
    return bool(model.provenance.get("snapshots") != (~tried.snapshots.held_out).sum())


def _full_model(tried: Tried, run: FullModelRun | None, inputs: Mapping[str, FloatArray]) -> dict[str, FullModelTime]:
    if run is None:
        return {kind: stored_time(tried.path, tried.snapshots, kind) for kind in inputs}
    return {kind: measured_time(run, rows) for kind, rows in inputs.items()}
