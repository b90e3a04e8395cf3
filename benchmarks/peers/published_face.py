"""Seconds of our full model on the published face: all muscles at half activation, from rest."""

from __future__ import annotations

import os
import statistics
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from risorius_offline.anatomy import load_source
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel
from risorius_offline.newton import SolverReport

REPETITIONS = 3
HALF = 0.5
ROOT = Path(os.environ.get("RISORIUS_ANATOMY_DIR", Path(__file__).parents[3] / "shared" / "anatomy"))
FOLDER = ROOT / "artisynth_face"


@dataclass(frozen=True)
class FaceRow:
    """Medians in seconds of the processor (`wall_s`: of the clock) but for `least_s`; setup_s is before the solve."""

    components: int
    setup_s: float
    solve_s: float
    least_s: float
    wall_s: float
    report: SolverReport


def measure() -> FaceRow | None:
    """None where the face is absent. A gentler solve goes before, so that no compilation is in the figures."""
    if not FOLDER.is_dir():
        return None
    anatomy = load_source(str(FOLDER))
    _timed(anatomy, 0.1 * HALF)
    setup, solve, wall, reports = zip(*(_timed(anatomy, HALF) for _ in range(REPETITIONS)), strict=True)
    setup_s, solve_s, wall_s = map(statistics.median, (setup, solve, wall))
    return FaceRow(anatomy.points.size, setup_s, solve_s, min(solve), wall_s, reports[-1])


def _timed(anatomy: Anatomy, activation: float) -> tuple[float, float, float, SolverReport]:
    """Seconds of set-up and solve, of the solve by the clock, and its report; the model is a fresh one."""
    start = time.process_time()
    model = FullModel(anatomy)
    model.lift_fields  # noqa: B018  computed on first use, with the symbolic analysis
    parameters = np.zeros(len(anatomy.inputs.parameters))
    parameters[: model.muscle_count] = activation
    prepared, wall = time.process_time(), time.perf_counter()
    report = EquilibriumSolver(model).solve(parameters).report
    return prepared - start, time.process_time() - prepared, time.perf_counter() - wall, report
