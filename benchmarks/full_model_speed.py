"""Our full model beside felupe and scikit-fem on the same block, and the published face alone; one thread.

python benchmarks/full_model_speed.py [-o FILE.json]
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from peers import one_thread  # noqa: F401  before all that starts threads

# isort: split

import numpy as np
import pypardiso
from peers import felupe_block, scikit_fem_block
from peers.block import DRAG, POISSON, YOUNG, Block
from rich.console import Console
from rich.table import Table

from risorius.jaw import JawMotion
from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy import load_source
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.discretisation import CellBlock
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel

TOLERANCE = 1e-8
STEPS = 4
REPETITIONS = 3
LONG_S = 20.0  # what takes longer runs once
SMALL, LARGE = (12, 12, 4), (20, 20, 6)
OURS = "Risorius, PARDISO"
ROOT = Path(__file__).resolve().parent.parent


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, help="write the figures as JSON")
    output = parser.parse_args().output
    console = Console()
    results: dict[str, Any] = {}
    for cells in (SMALL, LARGE):
        rows = measure_block(cells)
        results["x".join(map(str, cells))] = rows
        console.print(block_table(cells, rows))
    results["face"] = measure_face(console)
    if output:
        output.write_text(json.dumps(results, indent=1), encoding="utf-8")
    return 0


def measure_block(cells: tuple[int, int, int]) -> dict[str, dict[str, float]]:
    """Seconds of every code, in turn, after one round that compiles; and how far each is from ours."""
    block = Block.of(cells, STEPS)
    codes: dict[str, Callable[[], np.ndarray]] = {
        OURS: lambda: ours(block, "pardiso"),
        "Risorius, SuperLU": lambda: ours(block, "superlu"),
        "felupe, its default (SuperLU)": lambda: felupe_block.solve(block, TOLERANCE),
        "felupe, PARDISO": lambda: felupe_block.solve(block, TOLERANCE, pypardiso.spsolve),
    }
    if cells == SMALL:  # its assembly takes minutes on the other
        codes["scikit-fem, SuperLU"] = lambda: scikit_fem_block.solve(block, TOLERANCE)
    ours(Block.of((2, 2, 2), 1), "pardiso")  # compiles
    seconds: dict[str, list[float]] = {name: [] for name in codes}
    found: dict[str, np.ndarray] = {}
    for repetition in range(REPETITIONS):
        for name, run in codes.items():
            if repetition and seconds[name][0] > LONG_S:
                continue
            start = time.process_time()
            found[name] = run()
            seconds[name].append(time.process_time() - start)
    scale = np.abs(found[OURS]).max()
    return {
        name: {
            "median_s": statistics.median(times),
            "min_s": min(times),
            "times_ours": statistics.median(a / b for a, b in zip(times, seconds[OURS], strict=False)),
            "difference": float(np.abs(found[name] - found[OURS]).max() / scale),
        }
        for name, times in seconds.items()
    }


def ours(block: Block, solver: str) -> np.ndarray:
    cells = CellBlock("hexahedron", block.hexahedra, np.zeros(len(block.hexahedra), dtype=np.int64))
    anatomy = Anatomy(
        name="block",
        points=block.points,
        cells=(cells,),
        materials=(Yeoh.neo_hookean(YOUNG, POISSON),),
        skull=block.held,
        jaw=block.dragged,
        skin=np.zeros((0, 3), dtype=np.int64),
        muscles=(),
        jaw_motion=JawMotion((0.0, 0.0, 0.0), 0.0, 0.0, 0.0, sideways_slide=DRAG),
    )
    solve = EquilibriumSolver(FullModel(anatomy, mean_dilatation=False, solver=solver), tolerance=TOLERANCE).solve
    state = None
    for step in range(1, block.steps + 1):
        state = solve(np.array([0.0, 0.0, step / block.steps]), state)
        if state.report.steps != 1:
            raise RuntimeError(f"load step {step} was divided: the comparison needs equal steps")
    return state.u


def measure_face(console: Console) -> dict[str, float] | None:
    """The published face with all muscles at half activation, from rest, set up and compiled before."""
    folder = Path(os.environ.get("RISORIUS_ANATOMY_DIR", ROOT.parent / "shared" / "anatomy")) / "artisynth_face"
    if not folder.is_dir():
        console.print(f"the published face is not at {folder}; set RISORIUS_ANATOMY_DIR")
        return None
    model = FullModel(load_source(str(folder)))
    solver = EquilibriumSolver(model)
    half = np.zeros(len(model.anatomy.inputs.parameters))
    half[: model.muscle_count] = 0.5
    solver.solve(0.1 * half)
    times, report = [], None
    for _ in range(REPETITIONS):
        start = time.process_time()
        report = solver.solve(half).report
        times.append(time.process_time() - start)
    console.print(
        f"published face, all muscles at 0.5 from rest, {model.discretisation.dof_count} components: median "
        f"{statistics.median(times):.2f} s, {report.iterations} iterations, {report.factorisations} factorisations, "
        f"smallest J {report.smallest_jacobian:.3f}"
    )
    return {"median_s": statistics.median(times), "min_s": min(times), "iterations": report.iterations}


def block_table(cells: tuple[int, int, int], rows: dict[str, dict[str, float]]) -> Table:
    count = 3 * int(np.prod(np.array(cells) + 1))
    table = Table(title=f"block of {' x '.join(map(str, cells))} hexahedra, {count} components, {STEPS} load steps")
    for column in ("code", "median s", "least s", "times ours", "largest difference"):
        table.add_column(column, justify="left" if column == "code" else "right")
    for name, row in rows.items():
        figures = (
            f"{row['median_s']:.3f}",
            f"{row['min_s']:.3f}",
            f"{row['times_ours']:.1f}",
            f"{row['difference']:.1e}",
        )
        table.add_row(name, *figures)
    return table


if __name__ == "__main__":
    sys.exit(main())
