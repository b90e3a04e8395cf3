"""Greedy refinement: further snapshots where the reduced model so far is least to be trusted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
from distributed import Client

from risorius.committee import disagreement
from risorius.inputs import InputTable
from risorius.jaw import FloatArray
from risorius.snapshot_file import SnapshotSet
from risorius.snapshot_store import Samples, SnapshotStore
from risorius.training import project, train
from risorius_offline.paths import Status, solve_waiting
from risorius_offline.sampling import PATH_LENGTH, training_sequence

KIND = "adaptive"
CANDIDATES = 1024
SMALLEST_ROUND, SHARE_OF_PRESENT = 8, 0.1


@dataclass(frozen=True)
class Goal:
    """When to stop: at `count` training samples, or when the held-out error (95 %, metres) is at most `error`.

    rank: of the reduced model that is asked. seed: of the design that the candidates are from.
    """

    count: int
    error: float
    rank: int
    seed: int


def refine(store: SnapshotStore, client: Client, model: str, report: Callable[[Status], None], goal: Goal) -> float:
    """Add samples in rounds and solve them, until the goal is reached; what waits in the store is solved first.

    Returns the error that was reached. Raises what `solve_waiting` and training do.
    """
    total = goal.count + int(store.held_out.sum())
    error: float | None = None
    last: list[Status] = []

    def told(status: Status) -> None:
        last[:] = [replace(status, total=total, error=error)]
        report(last[0])

    solve_waiting(store, client, model, told)
    while True:
        snapshots = SnapshotSet.load(store.path)
        modal = project(snapshots, goal.rank)
        error = train(snapshots, modal).accuracy["rational"].p95
        present = int((~store.held_out).sum())
        missing = goal.count - present
        if missing <= 0 or error <= goal.error:
            told(last[0])
            return error
        candidates = _candidates(store, snapshots.inputs, goal)
        wanted = min(missing, max(SMALLEST_ROUND, round(SHARE_OF_PRESENT * present)))
        store.add(_round(store, candidates[_worst(disagreement(snapshots, modal, candidates), candidates, wanted)]))
        solve_waiting(store, client, model, told)


def _candidates(store: SnapshotStore, inputs: InputTable, goal: Goal) -> FloatArray:
    """Parameters (c, p) that the design would come to later, and that are not in the store."""
    known = {row.tobytes() for row in store.parameters}
    longest = len(store.parameters) + CANDIDATES
    fresh = (row for _, row in training_sequence(inputs, goal.seed, longest) if row.tobytes() not in known)
    return np.array(list(islice(fresh, CANDIDATES)))


def _worst(spread: FloatArray, candidates: FloatArray, wanted: int) -> list[int]:
    """Candidates of the largest spread, each weighed with its distance to those taken before it in this round."""
    chosen: list[int] = []
    weight = np.ones(len(spread))
    for _ in range(min(wanted, len(spread))):
        chosen.append(int(np.argmax(spread * weight)))
        weight = np.minimum(weight, np.linalg.norm(candidates - candidates[chosen[-1]], axis=1))
    return chosen


def _round(store: SnapshotStore, parameters: FloatArray) -> Samples:
    """Samples on paths of their own: those of the design must not depend on what was added."""
    first = min(0, int(store.paths.min())) - 1
    paths = first - np.arange(len(parameters)) // PATH_LENGTH
    return Samples(parameters, [KIND] * len(parameters), np.zeros(len(parameters), bool), paths)
