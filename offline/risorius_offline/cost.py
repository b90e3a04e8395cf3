"""What a run of snapshots would take, from one sample that is solved here and now."""

from __future__ import annotations

import math
import resource
import shutil
import sys
from dataclasses import dataclass

import psutil

from risorius.errors import SolverError
from risorius.snapshot_file import SOLVED, reading
from risorius.snapshot_store import Samples
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.sample import SampleSolver
from risorius_offline.snapshots import Run

WARM_UP = 0.01  # weight of a sample that compiles the kernels before anything is timed
TIMED_KINDS = ("ordinary", "strong", "single")  # the first of these in the design is timed


@dataclass(frozen=True)
class Cost:
    """Samples left to solve and workers; CPU seconds and bytes on disk of one sample; bytes of memory of a worker.

    free_disk: bytes free where the file is to be. free_memory: bytes of this machine that are available.
    """

    samples: int
    workers: int
    seconds_each: float
    disk_each: int
    memory_each: int
    free_disk: int
    free_memory: int

    @property
    def seconds(self) -> float:
        """Wall time with all workers busy."""
        return math.ceil(self.samples / max(self.workers, 1)) * self.seconds_each

    @property
    def disk(self) -> int:
        """Bytes of the snapshots that are left."""
        return self.samples * self.disk_each

    @property
    def memory(self) -> int:
        """Bytes of all workers."""
        return self.workers * self.memory_each


def estimate(run: Run, plan: Samples, workers: int) -> Cost:
    """Solve one sample of a plan and scale it up. Raises SolverError when it has no equilibrium."""
    choice = run.choice
    solver = SampleSolver(EquilibriumSolver(choice.effects.model(choice.anatomy)), choice.derivatives)
    kind = next(kind for kind in TIMED_KINDS if kind in plan.kinds)
    timed = plan.parameters[list(plan.kinds).index(kind)]
    solver.solve(WARM_UP * timed, None, [])
    outcome = solver.solve(timed, None, [])
    solved = outcome.solved
    if solved is None:
        raise SolverError(f"the sample that was to be timed has no equilibrium: {outcome.failure}")
    return Cost(
        samples=len(plan.parameters) - _already_solved(run),
        workers=workers,
        seconds_each=outcome.report["seconds"],
        disk_each=sum(map(len, solved.fields.values())),
        memory_each=_peak_memory(),
        free_disk=shutil.disk_usage(run.output.parent).free,
        free_memory=_available_memory(),
    )


def _already_solved(run: Run) -> int:
    if not run.output.exists():
        return 0
    with reading(run.output) as file:
        return int((file["samples/state"][()] == SOLVED).sum())


def _peak_memory() -> int:
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def _available_memory() -> int:
    return int(psutil.virtual_memory().available)
