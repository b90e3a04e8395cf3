"""`risorius report`: accuracy against time."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from risorius.commands.settings import SceneFile
from risorius.errors import InputError


def report(
    model: Annotated[Path, typer.Argument(help="Model file.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder to write.")] = Path("report"),
    snapshots: Annotated[
        Path | None, typer.Option(help="Snapshot file of the model; MODEL.snapshots.h5 beside it unless given.")
    ] = None,
    anatomy: Annotated[
        str | None, typer.Option(help="Anatomy of the snapshots: solves the full model in the same run.")
    ] = None,
    effects: Annotated[
        bool, typer.Option("--effects", help="Measure instead what every effect of a scene costs and is worth.")
    ] = False,
    scene: SceneFile = None,
    timeline: Annotated[
        Path | None, typer.Option(help="With --effects or --scene: CSV file of OpenFace or of inputs to play.")
    ] = None,
) -> None:
    """Measure what accuracy costs in time: a table, a plot and a page of every evaluator and the full model."""
    if effects or scene is not None:
        if snapshots is not None or anatomy is not None:
            raise InputError("--snapshots and --anatomy: not with --effects or --scene, which play a --timeline")
        _report_effects(model, scene, timeline, output)
        return
    if timeline is not None:
        raise InputError("--timeline: is played with --effects or --scene; give one of them")
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


def _report_effects(model: Path, scene: Path | None, timeline: Path | None, output: Path) -> None:
    from risorius.model import load
    from risorius.report.effects import as_csv, prices, sentences
    from risorius.report.files import require_folder
    from risorius.scene import Scene
    from risorius.storage import replaced_when_complete
    from risorius.timeline import Timeline

    require_folder(output)
    wanted, loaded = Scene() if scene is None else Scene.load(scene), load(model)
    table = loaded.inputs
    played = Timeline.of_expressions(table) if timeline is None else Timeline.read(timeline, table)
    found = prices(loaded, wanted, played)
    output.mkdir(exist_ok=True)
    with replaced_when_complete(output / "effects.csv") as partial:
        partial.write_text(as_csv(found), encoding="utf-8")
    for sentence in sentences(found):
        typer.echo(sentence)


def snapshots_beside(model: Path) -> Path | None:
    """Where `risorius train` leaves the snapshots of a model; None when there are none."""
    beside = model.with_suffix(".snapshots.h5")
    return beside if beside.is_file() else None
