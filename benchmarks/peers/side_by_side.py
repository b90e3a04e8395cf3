"""Times codes on one block in turn, A B C A B C: what else the machine does falls on all of them alike."""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from peers import risorius_block
from peers.block import Block, Solution

Code = Callable[[Block], Callable[[], Solution]]

REPETITIONS = 3
LONG_S = 8.0  # what takes longer runs once, the first code excepted


@dataclass(frozen=True)
class Row:
    """Seconds of the processor (`wall_s`: of the clock), medians but for `least_s`; set-up and solve unless said.

    times_first: median over its turns of the ratio to the first code in the same turn. iteration_s: of the solve alone.
    difference: the largest of displacements from the first code's, relative to the largest displacement. residual: by
    our forces.
    """

    runs: int
    median_s: float
    least_s: float
    wall_s: float
    setup_s: float
    iterations: int
    factorisations: int
    iteration_s: float
    times_first: float
    difference: float
    residual: float


@dataclass(frozen=True)
class Run:
    setup_s: float
    solve_s: float
    wall_s: float
    solution: Solution

    @property
    def total_s(self) -> float:
        return self.setup_s + self.solve_s


def side_by_side(block: Block, codes: dict[str, Code]) -> dict[str, Row]:
    """A row for every code, all of them compared with the first."""
    runs: dict[str, list[Run]] = {name: [] for name in codes}
    first = next(iter(runs.values()))
    for turn in range(REPETITIONS):
        for name, prepare in codes.items():
            own = runs[name]
            if turn == 0 or own is first or own[0].total_s <= LONG_S:
                own.append(timed(block, prepare))
    return {name: _row(block, own, first) for name, own in runs.items()}


def timed(block: Block, prepare: Code) -> Run:
    """Set-up and solve of one code."""
    gc.collect()
    wall, start = time.perf_counter(), time.process_time()
    solve = prepare(block)
    prepared = time.process_time()
    solution = solve()
    end = time.process_time()
    return Run(prepared - start, end - prepared, time.perf_counter() - wall, solution)


def _row(block: Block, runs: Sequence[Run], first: Sequence[Run]) -> Row:
    totals, found, ours = [run.total_s for run in runs], runs[-1].solution, first[-1].solution.u
    return Row(
        runs=len(runs),
        median_s=statistics.median(totals),
        least_s=min(totals),
        wall_s=statistics.median(run.wall_s for run in runs),
        setup_s=statistics.median(run.setup_s for run in runs),
        iterations=found.iterations,
        factorisations=found.factorisations,
        iteration_s=statistics.median(run.solve_s for run in runs) / found.iterations,
        times_first=statistics.median(own / one.total_s for own, one in zip(totals, first, strict=False)),
        difference=float(np.abs(found.u - ours).max() / np.abs(ours).max()),
        residual=risorius_block.residual(block, found.u),
    )
