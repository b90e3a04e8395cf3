"""What lies between a learned map and the full model: the full model, going on from the map's answer.

A fifth of a second buys what no reduced model of a millisecond reaches.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from risorius.accuracy import HeldOut
from risorius.errors import InputError
from risorius.evaluators import Setting
from risorius.jaw import FloatArray
from risorius.model import ReducedModel
from risorius.operating_point import most_accurate
from risorius.pipeline import pipelines
from risorius.report.candidates import MAPS, Family, OfflineCost, family_of
from risorius.report.full_model import FullModelRun
from risorius.report.measuring import Times
from risorius.report.results import Row
from risorius.snapshot_file import SnapshotSet
from risorius.training import project

CONTINUED = Family("full model from the map", 3, "#009E73", "D")
TANGENTS = (1, 2, 3, 5)
END = "to equilibrium"
SAME_MODES, SAME_COARSE = 1e-3, 1e-2  # of the largest component: rounding, not another set of snapshots


@dataclass(frozen=True)
class _Stop:
    """Seconds until a stop on the way from one held-out snapshot's map, and what was seen there (v, 3), metres."""

    seconds: float
    seen: FloatArray


def continued(model: ReducedModel, snapshots: SnapshotSet, held_out: HeldOut, run: FullModelRun) -> Iterator[Row]:
    """Rows of the full model after some tangents and at its end, from the most accurate learned map of a model.

    Times are those of the held-out snapshots themselves, from nodal displacements to nodal displacements. No rows
    where the model has no learned map.
    """
    maps = tuple(point for point in model.points if family_of(point.setting) is MAPS)
    if not maps:
        return
    setting = most_accurate(maps).setting
    ways = [_stops(run, snapshots, *start) for start in _starts(model, snapshots, held_out, setting)]
    kinds = np.array(held_out.kinds)
    for name in ways[0]:
        errors = held_out.by_kind(held_out.errors(way[name].seen for way in ways))
        seconds = np.array([way[name].seconds for way in ways])
        for kind, found in errors.items():
            own = seconds[kinds == kind]
            times = Times(float(np.median(own)), float(np.quantile(own, 0.99)))
            point = f"{setting.method}, then full model, {name}"
            yield Row(point, CONTINUED.name, CONTINUED, kind, found, times, times, OfflineCost(None, None, None))


def _starts(
    model: ReducedModel, snapshots: SnapshotSet, held_out: HeldOut, setting: Setting
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Displacements (n, 3) of all nodes that the map gives, and parameters (p,), of every held-out snapshot."""
    fields, way = _nodal_fields(model, snapshots), pipelines(model, [setting])[0]
    for parameters in held_out.parameters:
        way.solve(parameters)
        yield np.tensordot(way.coordinates, fields, axes=1), parameters


def _nodal_fields(model: ReducedModel, snapshots: SnapshotSet) -> FloatArray:
    """What one unit of each coordinate of a model moves all nodes by (r, n, 3); its file knows those that carry skin.

    Modes are made of the snapshots anew: these nodes tell the sign, and whether they are the model's.
    """
    modes = project(snapshots, model.rank - model.lifts).modes
    carriers = np.unique(snapshots.surface.weights.indices)
    theirs, ours = modes[:, carriers], model.carried_basis.fields[model.lifts :]
    signs = np.sign(np.einsum("rmc, rmc -> r", theirs, ours))[:, None, None]
    coarse = model.carried_basis.coarse
    rounding = SAME_MODES if coarse is None else np.where(coarse[model.lifts :], SAME_COARSE, SAME_MODES)
    if not (np.abs(signs * theirs - ours).max(axis=(1, 2)) < rounding * np.abs(ours).max()).all():
        raise InputError(f"model {model.name!r}: modes of its snapshots are others; train it anew from them")
    fields = np.concatenate([snapshots.lift_fields, signs * modes])
    fields[:, carriers] = model.carried_basis.fields
    return fields


def _stops(run: FullModelRun, snapshots: SnapshotSet, guess: FloatArray, parameters: FloatArray) -> Mapping[str, _Stop]:
    way = run.way_from(guess, parameters)
    numbers = {f"{count} tangent{'s'[: count > 1]}": count for count in TANGENTS} | {END: len(way) - 1}
    stops = {name: way[min(number, len(way) - 1)] for name, number in numbers.items()}
    return {name: _Stop(seconds, snapshots.surface.weights @ u) for name, (seconds, u) in stops.items()}
