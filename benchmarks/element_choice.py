"""Error against seconds of every element: benchmarks/element_choice.py [cook|slab|cheek|face|all] -o DIRECTORY.

Writes a table (CSV) for each problem, a plot of all in the directory, and prints a summary in Markdown. Errors are of
the displacement at the nodes of the coarsest mesh, which all meshes share, against a reference in finer quadratic
tetrahedra. Seconds are processor time of one equilibrium from rest with one thread; the symbolic analysis, once for a
mesh, is not counted. All parts take half an hour of a quiet core and 10 GiB.
"""

from __future__ import annotations

import os

os.environ.update(OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1", NUMBA_NUM_THREADS="1")

import argparse
import csv
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from element_report import report
from meshes.problems import PROBLEMS, Problem
from meshes.refinement import refined, with_edge_nodes
from meshes.splits import tetrahedral, wedged

from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.discretisation import Discretisation
from risorius_offline.effects import DeadLoad
from risorius_offline.equilibrium import Equilibrium, EquilibriumSolver, NotConvergedError
from risorius_offline.full_model import FullModel

POISSON = (0.45, 0.49, 0.499)


@dataclass(frozen=True)
class Mesh:
    """A problem's mesh of one element; level 0 is the coarsest."""

    element: str
    level: int
    anatomy: Anatomy


@dataclass(frozen=True)
class Solved:
    """A state u (n, 3), NaN where there is none, and what it took."""

    u: np.ndarray
    free_components: int
    seconds: float
    factorisations: int


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("problem", choices=[*PROBLEMS, "all"], nargs="?", default="all")
    parser.add_argument("-o", "--output", type=Path, default=Path("benchmarks/results"))
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    for name in PROBLEMS if arguments.problem == "all" else [arguments.problem]:
        with (arguments.output / f"elements_{name}.csv").open("w", newline="", buffering=1) as file:
            for number, row in enumerate(measurements(PROBLEMS[name]())):
                writer = csv.DictWriter(file, row.keys())
                if number == 0:
                    writer.writeheader()
                writer.writerow(row)
                print(*row.values(), flush=True)
    report(arguments.output)


def measurements(problem: Problem) -> Iterator[dict[str, object]]:
    """One row for every solve, the reference of a Poisson's ratio before those that are compared with it."""
    measured, finest = meshes(problem)
    volumes = Discretisation(problem.coarsest.points, problem.coarsest.cells).nodal_volumes
    solve(problem, problem.coarsest, POISSON[0], True)  # compiles the kernels
    start = None
    for poisson in POISSON:
        reference = solve(problem, finest.anatomy, poisson, True, start)
        start = Equilibrium(problem.activations, reference.u)
        yield row(problem, finest, poisson, True, reference, reference.u, volumes)
        for mesh in measured:
            # A linear tetrahedron has one point: its mean dilatation is that of the point.
            for mean_dilatation in (False,) if mesh.element == "tetra" else (False, True):
                found = solve(problem, mesh.anatomy, poisson, mean_dilatation)
                yield row(problem, mesh, poisson, mean_dilatation, found, reference.u, volumes)


def meshes(problem: Problem) -> tuple[list[Mesh], Mesh]:
    """What is measured, and the mesh of the reference."""
    measured = []
    anatomy = problem.coarsest
    for level in range(max(problem.levels, problem.reference + 1)):
        tetrahedra = tetrahedral(anatomy)
        if level < problem.levels:
            measured += [Mesh("hexahedron", level, anatomy), Mesh("tetra", level, tetrahedra)]
            if problem.numbered_alike:
                measured.append(Mesh("wedge", level, wedged(anatomy)))
        if level <= problem.reference:
            measured.append(Mesh("tetra10", level, with_edge_nodes(tetrahedra)))
        anatomy = refined(anatomy)
    finest = max((mesh for mesh in measured if mesh.element == "tetra10"), key=lambda mesh: mesh.level)
    return [mesh for mesh in measured if mesh is not finest], finest


def solve(
    problem: Problem, mesh: Anatomy, poisson: float, mean_dilatation: bool, start: Equilibrium | None = None
) -> Solved:
    """Equilibrium of a problem on a mesh."""
    mesh = replace(mesh, materials=problem.with_poisson(poisson))
    effects = [DeadLoad(problem.load(mesh))] if problem.load else []
    model = FullModel(mesh, effects, mean_dilatation=mean_dilatation)
    if problem.held:
        held = np.repeat(mesh.skull[:, None], 3, axis=1) | problem.held(mesh)
        model.free, model.prescribed = np.flatnonzero(~held), np.flatnonzero(held)
    model.tangent(np.zeros_like(mesh.points))  # the tables and the analysis are made once for a mesh
    _ = model.system, model.lift_fields
    begin = time.process_time()
    try:
        found = EquilibriumSolver(model).solve(problem.activations, start)
    except NotConvergedError as error:
        u, report = np.full_like(mesh.points, np.nan), error.report
    else:
        u, report = found.u, found.report
    return Solved(u, len(model.free), time.process_time() - begin, report.factorisations)


def row(
    problem: Problem,
    mesh: Mesh,
    poisson: float,
    mean_dilatation: bool,
    found: Solved,
    reference: np.ndarray,
    volumes: np.ndarray,
) -> dict[str, object]:
    """Errors at the nodes of the coarsest mesh, which come first in all: relative L2 in percent, mean and max in mm."""
    count = len(volumes)
    off = np.linalg.norm(found.u[:count] - reference[:count], axis=1)
    size = np.linalg.norm(reference[:count], axis=1)
    return {
        "problem": problem.name,
        "poisson": poisson,
        "element": mesh.element,
        "mean_dilatation": mean_dilatation,
        "level": mesh.level,
        "free_components": found.free_components,
        "error_percent": f"{100.0 * np.sqrt(volumes @ off**2 / (volumes @ size**2)):.3f}",
        "mean_mm": f"{1e3 * (volumes @ off) / volumes.sum():.4f}",
        "max_mm": f"{1e3 * off.max():.3f}",
        "seconds": f"{found.seconds:.3g}",
        "factorisations": found.factorisations,
    }


if __name__ == "__main__":
    main()
