"""`risorius report`: accuracy against time."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def report(
    model: Annotated[Path, typer.Argument(help="Model file.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder to write.")] = Path("report"),
    snapshots: Annotated[
        Path | None, typer.Option(help="Snapshot file of the model; MODEL.snapshots.h5 beside it unless given.")
    ] = None,
    anatomy: Annotated[
        str | None, typer.Option(help="Anatomy of the snapshots: solves the full model in the same run.")
    ] = None,
) -> None:
    """Measure what accuracy costs in time: a table, a plot and a page of every evaluator and the full model."""
    from risorius.model import load
    from risorius.report.files import require_folder, write
    from risorius.report.measurement import Tried, measure, measure_times
    from risorius.report.plot import require_matplotlib
    from risorius.report.verdict import verdict

    require_matplotlib()
    require_folder(output)
    loaded = load(model)
    beside = snapshots_beside(model) if snapshots is None else snapshots
    results = measure_times(loaded) if beside is None else measure(loaded, Tried.of(beside, loaded), anatomy)
    write(results, output)
    typer.echo(f"{output / 'index.html'}: errors {results.errors_from}")
    for sentence in verdict(results):
        typer.echo(sentence)


def snapshots_beside(model: Path) -> Path | None:
    """Where `risorius train` leaves the snapshots of a model; None when there are none."""
    beside = model.with_suffix(".snapshots.h5")
    return beside if beside.is_file() else None
