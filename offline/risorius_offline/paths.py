"""The waiting samples of a snapshot file as tasks of a Dask cluster.

Samples are solved along short paths, each from what the first samples of the file let expect there, or from the nearest
equilibrium that its path has so far, so that results depend neither on the number of workers nor on where a run was
interrupted. Each sample is a task of its own that depends on
those before it on its path: Dask keeps a path on one worker, and repeats on another what a lost worker had.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import distributed
import numpy as np
from distributed import Client, Future

from risorius.errors import SolverError
from risorius.snapshot_file import FAILED, SOLVED, WAITING
from risorius.snapshot_store import SnapshotStore
from risorius_offline.cluster import solve_on_worker
from risorius_offline.foundation import Interpolation, foundation
from risorius_offline.sample import Outcome, State

POLL_SECONDS = 0.5
RESULT_SECONDS = 30.0  # for some megabytes to arrive
PATHS_PER_WORKER = 2  # one in work, one ready
# A cluster may take its time; workers of this machine that do not come back in this time will not.
LONGEST_WITHOUT_LOCAL_WORKERS = 120.0


@dataclass(frozen=True)
class Status:
    """Numbers of samples solved, given up and in all, and of workers.

    error: of the reduced model so far, metres, on held-out snapshots; None unless it is looked for.
    """

    solved: int
    failed: int
    total: int
    workers: int
    error: float | None = None


def solve_waiting(store: SnapshotStore, client: Client, model: str, report: Callable[[Status], None]) -> None:
    """Solve all samples that wait in a store, with the model of that name on the workers.

    Raises SolverError when the scheduler is lost, Error when the disk is full: what was finished before is kept.
    """
    work = _Work(store, client, model)
    try:
        while work.submit_paths():
            report(work.status())
            work.collect()
        report(work.status())
    except (distributed.CancelledError, OSError) as error:
        if isinstance(error, OSError) and client.status == "running":
            raise
        raise SolverError(
            f"{store.path}: the scheduler was lost; what was finished is kept, start the run again to go on"
        ) from error


class _Work:
    """Tasks in flight, by row, for each path that is begun."""

    def __init__(self, store: SnapshotStore, client: Client, model: str) -> None:
        self._store, self._client, self._model = store, client, model
        waiting = set(store.paths[store.states == WAITING].tolist())
        # In the order of their first rows: what a path waits for is not behind it.
        self._untouched = deque(path for path in dict.fromkeys(store.paths.tolist()) if path in waiting)
        self._interpolations: dict[int, Interpolation | None] = {0: None}
        self._begun: dict[int, dict[int, Future]] = {}
        self._suspects: deque[int] = deque()
        self._alone: int | None = None
        self._workers, self._last_worker = 0, time.monotonic()

    def status(self) -> Status:
        """Where the run stands."""
        states = self._store.states
        return Status(int((states == SOLVED).sum()), int((states == FAILED).sum()), len(states), self._workers)

    def submit_paths(self) -> bool:
        """Keep all workers busy; return whether anything is left to wait for."""
        self._count_workers()
        most = PATHS_PER_WORKER * max(1, self._workers)
        while self._untouched and len(self._begun) < most and self._is_ready(self._untouched[0]):
            self._submit(self._untouched.popleft())
        if not self._begun and self._suspects:
            self._alone = self._suspects.popleft()
            self._submit(self._alone)
        return bool(self._begun)

    def _foundation(self, path: int) -> int:
        return foundation(int(np.argmax(self._store.paths == path)))

    def _is_ready(self, path: int) -> bool:
        return not (self._store.states[: self._foundation(path)] == WAITING).any()

    def _count_workers(self) -> None:
        self._workers = sum(self._client.nthreads().values())
        if self._workers:
            self._last_worker = time.monotonic()
        elif self._client.cluster and time.monotonic() - self._last_worker > LONGEST_WITHOUT_LOCAL_WORKERS:
            raise SolverError(
                f"{self._store.path}: the worker processes ended and do not start again; is memory short? What was "
                "finished is kept, start the run again to go on, with fewer --workers"
            )

    def collect(self) -> None:
        """Wait a moment for results, and record those that there are."""
        rows = {
            future: (path, row)
            for path, tasks in self._begun.items()
            for row, future in tasks.items()
            if self._store.states[row] == WAITING
        }
        try:
            with self._client.as_current():
                done = distributed.wait(list(rows), POLL_SECONDS, "FIRST_COMPLETED").done
        except distributed.TimeoutError:
            return
        for path, row in sorted(rows[future] for future in done):
            if row in self._begun.get(path, ()):
                self._take(path, row)

    def _submit(self, path: int) -> None:
        """Submit the waiting samples of a path, each with what comes before it there."""
        store, tasks = self._store, dict[int, Future]()
        known: list[State] = []
        expected = self._interpolation(self._foundation(path))
        for row in np.flatnonzero(store.paths == path).tolist():
            if store.states[row] == SOLVED:
                known.append(State(store.parameters[row], store.displacement(row)))
            elif store.states[row] == WAITING:
                guess = expected.displacement(store.parameters[row]) if expected else None
                arguments = (self._model, store.parameters[row], guess, tuple(known), *tasks.values())
                tasks[row] = self._client.submit(solve_on_worker, *arguments, pure=False)
        self._begun[path] = tasks

    def _interpolation(self, count: int) -> Interpolation | None:
        """Between the first samples; only the last one asked for is kept."""
        if count not in self._interpolations:
            self._interpolations = {0: None, count: Interpolation.of(self._store, count)}
        return self._interpolations[count]

    def _take(self, path: int, row: int) -> None:
        """Record a finished task; the last of a path lets go of them all."""
        tasks = self._begun[path]
        try:
            outcome: Outcome = tasks[row].result(timeout=RESULT_SECONDS)
        except distributed.TimeoutError:  # its worker was lost meanwhile; the task is done once more
            return
        except distributed.KilledWorker as error:
            self._blame(path, error)
            return
        if outcome.solved:
            self._store.record(row, outcome.solved)
        else:
            self._store.give_up(row, self._described(row, outcome.failure), outcome.report)
        if all(self._store.states[other] != WAITING for other in tasks):
            del self._begun[path]

    def _blame(self, path: int, error: distributed.KilledWorker) -> None:
        """Solve a path again by itself when workers died; then give up the sample that ends one after the other.

        Before, it may have been another sample that the same workers had in work.
        """
        if path != self._alone:
            del self._begun[path]
            self._suspects.append(path)
            return
        row = min(row for row in self._begun[path] if self._store.states[row] == WAITING)
        reason = f"the worker process ended in its solve, {error.allowed_failures + 1} times; is memory short there?"
        self._store.give_up(row, self._described(row, reason), {})
        del self._begun[path]
        if (self._store.states[self._store.paths == path] == WAITING).any():
            self._submit(path)

    def _described(self, row: int, reason: str) -> str:
        return f"sample {row} ({self._store.kinds[row].decode()}): {reason}"
