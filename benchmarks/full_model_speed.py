"""Our full model beside felupe and scikit-fem on the same blocks, and the published face alone; one thread.

python benchmarks/full_model_speed.py [CASE ...] [-o FILE.json]
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

from peers import one_thread  # noqa: F401  before all that starts threads

# isort: split

import pypardiso
from peers import felupe_block, published_face, risorius_block, scikit_fem_block
from peers.block import STEPS, Block
from peers.scikit_fem_forms import HandedOver, InTheForm
from peers.side_by_side import Code, Row, side_by_side, timed
from rich.console import Console
from rich.table import Table

OURS: dict[str, Code] = {"Risorius, PARDISO": lambda block: risorius_block.prepare(block, "pardiso")}
OURS_SUPERLU: dict[str, Code] = {"Risorius, SuperLU": lambda block: risorius_block.prepare(block, "superlu")}
FELUPE: dict[str, Code] = {
    "felupe, SuperLU (default)": felupe_block.prepare,
    "felupe, PARDISO": lambda block: felupe_block.prepare(block, pypardiso.spsolve),
}
SCIKIT_FEM: dict[str, Code] = {
    "scikit-fem, SuperLU (default)": lambda block: scikit_fem_block.prepare(block, HandedOver),
}
SCIKIT_FEM_PARDISO: dict[str, Code] = {
    "scikit-fem, PARDISO": lambda block: scikit_fem_block.prepare(block, HandedOver, pypardiso.spsolve),
}
EXAMPLE_36: dict[str, Code] = {
    "scikit-fem as in its example 36, SuperLU": lambda block: scikit_fem_block.prepare(block, InTheForm),
}
ALL = OURS | OURS_SUPERLU | FELUPE | SCIKIT_FEM | SCIKIT_FEM_PARDISO

LAYERS = (15e3, 5e3, 50e3)  # muscle, fat and skin, pascals
# What would take minutes is left out of the larger cases.
CASES: dict[str, tuple[Block, dict[str, Code]]] = {
    "hex-small": (Block.of_hexahedra((12, 12, 4)), ALL | EXAMPLE_36),
    "hex-medium": (Block.of_hexahedra((20, 20, 6)), ALL),
    "hex-layers": (Block.of_hexahedra((20, 20, 6), LAYERS), OURS | OURS_SUPERLU | FELUPE),
    "hex-large": (Block.of_hexahedra((30, 30, 9)), OURS | FELUPE),
    "tet-small": (Block.of_tetrahedra((6, 6, 2)), OURS | OURS_SUPERLU | FELUPE | SCIKIT_FEM),
    "tet-medium": (Block.of_tetrahedra((10, 10, 3)), OURS | OURS_SUPERLU | FELUPE | SCIKIT_FEM),
}
FACE = "face"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = [*CASES, FACE]
    parser.add_argument("cases", nargs="*", metavar="CASE", help=f"of {', '.join(names)}; all by default")
    parser.add_argument("-o", "--output", type=Path, help="write the figures as JSON")
    options = parser.parse_args()
    unknown = set(options.cases) - set(names)
    if unknown:
        parser.error(f"no case {', '.join(sorted(unknown))}; choose of {', '.join(names)}")
    results = measure(options.cases or names, Console())
    if options.output:
        options.output.write_text(json.dumps(results, indent=1), encoding="utf-8")
    return 0


def measure(names: list[str], console: Console) -> dict[str, Any]:
    """Figures by case, printed on the way."""
    results: dict[str, Any] = {"first solve": first_solve(console)}
    for name in names:
        if name == FACE:
            results[name] = face(console)
            continue
        block, codes = CASES[name]
        rows = side_by_side(block, codes)
        console.print(table(name, block, rows))
        results[name] = {code: asdict(row) for code, row in rows.items()}
    return results


def first_solve(console: Console) -> dict[str, float]:
    """Seconds that fresh processes take to compile our kernels, then to load them; every code is run once here."""
    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | {"NUMBA_CACHE_DIR": cache}
        command = [sys.executable, "-m", "peers.first_solve"]
        compiling, loading = (
            float(subprocess.check_output(command, env=environment, cwd=Path(__file__).parent, text=True))
            for _ in range(2)
        )
    console.print(f"our kernels: {compiling:.1f} s to compile, once; {loading:.2f} s to load in every process")
    for code in ALL.values():
        timed(Block.of_hexahedra((2, 2, 2)), code)
    return {"compile_s": compiling, "load_s": loading}


def face(console: Console) -> dict[str, Any] | None:
    """Figures of the published face; a message where it is absent."""
    row = published_face.measure()
    if row is None:
        console.print(f"the published face is not at {published_face.FOLDER}; set RISORIUS_ANATOMY_DIR")
        return None
    report = row.report
    console.print(
        f"published face, all muscles at {published_face.HALF} from rest, {row.components} components: "
        f"{row.solve_s:.2f} s of the processor, {row.wall_s:.2f} s of the clock (least {row.least_s:.2f} s) "
        f"after {row.setup_s:.2f} s of set-up; {report.iterations} iterations, {report.factorisations} factorisations, "
        f"{report.steps} load steps, smallest J {report.smallest_jacobian:.3f}, residual {report.residual:.0e}"
    )
    return asdict(row)


def table(name: str, block: Block, rows: dict[str, Row]) -> Table:
    """What a terminal shows of a case."""
    cells = f"{len(block.connectivity)} {block.cell_type} cells, {block.points.size} components"
    result = Table(title=f"{name}: {cells}, {STEPS} load steps; seconds of the processor")
    result.add_column("code")
    heads = (
        "median",
        "least",
        "wall",
        "set-up",
        "times ours",
        "iterations",
        "factors",
        "each",
        "difference",
        "residual",
    )
    for head in heads:
        result.add_column(head, justify="right")
    for code, row in rows.items():
        seconds = (row.median_s, row.least_s, row.wall_s, row.setup_s)
        result.add_row(
            code,
            *(f"{value:.2f}" for value in seconds),
            f"{row.times_first:.1f}",
            str(row.iterations),
            str(row.factorisations),
            f"{row.iteration_s:.4f}",
            f"{row.difference:.0e}",
            f"{row.residual:.0e}",
        )
    return result


if __name__ == "__main__":
    sys.exit(main())
