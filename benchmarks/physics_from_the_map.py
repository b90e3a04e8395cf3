"""What physics can add to a learned map at most: benchmarks/physics_from_the_map.py MODEL SNAPSHOTS SOURCE.

From the map's answer to every held-out snapshot the full model goes on to an equilibrium: what reduced physics
imitates with fewer unknowns. Prints errors of the visible vertices in mm, mean / 95 % / max, at the map,
where the tangent is made anew for the k-th time, and at the end. With contact the end may be another equilibrium than
the snapshot's.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

import risorius
from risorius.evaluators import NetworkMap
from risorius.snapshot_file import SnapshotSet
from risorius.training import project
from risorius_offline.anatomy import load_source
from risorius_offline.contact_choice import ContactChoice
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.equilibrium import EquilibriumSolver, NotConvergedError
from risorius_offline.full_model import FullModel
from risorius_offline.tangents import Tangents

TANGENTS = (1, 2, 3, 4, 6, 8)
SAME = 0.05e-3  # metres between vertices in one equilibrium


class WatchedModel(FullModel):
    """Keeps the displacements whose tangent was asked for, and the CPU seconds until then."""

    def watch(self) -> None:
        self._begin, self.passed = time.thread_time(), []

    def note(self, u: np.ndarray) -> None:
        self.passed.append((time.thread_time() - self._begin, u.copy()))

    def tangents(self, u: np.ndarray) -> Tangents:
        self.note(u)
        return super().tangents(u)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model", type=Path)
    parser.add_argument("snapshots", type=Path)
    parser.add_argument("source")
    parser.add_argument("--contact", type=ContactChoice, choices=list(ContactChoice), default=ContactChoice.LIPS)
    options = parser.parse_args()
    model, snapshots = risorius.load(options.model), SnapshotSet.load(options.snapshots)
    anatomy = load_source(options.source)
    full = WatchedModel(anatomy, EffectChoice(contact=options.contact).model(anatomy).effects)
    fields = np.concatenate([snapshots.lift_fields, project(snapshots, model.rank - model.lifts).modes])
    for kind in dict.fromkeys(np.array(snapshots.kinds)[snapshots.held_out]):
        rows = np.flatnonzero(snapshots.held_out & (np.array(snapshots.kinds) == kind))
        starts = [np.tensordot(answer(model, snapshots.parameters[row]), fields, axes=1) for row in rows]
        print(f"{kind}: {len(rows)} held-out snapshots")
        tell(full, snapshots, rows, starts)


def answer(model: risorius.ReducedModel, parameters: np.ndarray) -> np.ndarray:
    """Coordinates (r,), lifts first, that the learned map gives."""
    modal = np.empty(model.rank - model.lifts)
    model.evaluators[NetworkMap.name].coordinates(parameters, modal)
    return np.concatenate([model.poses.lift_coordinates(parameters[len(model.inputs.muscles) :]), modal])


def tell(full: WatchedModel, snapshots: SnapshotSet, rows: np.ndarray, starts: list[np.ndarray]) -> None:
    solver, ways, energies = EquilibriumSolver(full), [], []
    for row, start in zip(rows, starts, strict=True):
        full.watch()
        full.note(start)
        try:
            end = solver.settle(snapshots.parameters[row], start).u
        except NotConvergedError as error:
            print(f"  snapshot {row}: {error}")
            continue
        truth = snapshots.displacements[row].astype(np.float64)
        full.note(end)
        seen = snapshots.surface.weights
        ways.append([(seconds, np.linalg.norm(seen @ (u - truth), axis=1)) for seconds, u in full.passed])
        energies.append(full.energy(end) - full.energy(truth))
    print(f"  map            {summary([way[0] for way in ways])}")
    for count in TANGENTS:
        print(f"  tangent {count}      {summary([way[min(count, len(way) - 1)] for way in ways])}")
    print(f"  end            {summary([way[-1] for way in ways])}")
    same = np.array([way[-1][1].max() < SAME for way in ways])
    lower, others = int((np.array(energies)[~same] < 0.0).sum()), int((~same).sum())
    print(f"  {same.sum()} end in the snapshot's equilibrium, {lower} in one of less energy, {others - lower} of more")


def summary(states: list[tuple[float, np.ndarray]]) -> str:
    errors = 1e3 * np.concatenate([error for _, error in states])
    seconds = np.median([spent for spent, _ in states])
    return f"{errors.mean():.3f} / {np.quantile(errors, 0.95):.3f} / {errors.max():.2f} mm, {seconds:.2f} CPU s"


if __name__ == "__main__":
    main()
