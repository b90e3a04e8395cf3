"""`risorius reduce`: from snapshots to a reduced model."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from risorius.model import ReducedModel

DEFAULT_RANK = 240


def reduce(
    snapshots: Annotated[Path, typer.Argument(help="Snapshot file.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Model file to write.")] = Path("model.h5"),
    rank: Annotated[int, typer.Option(min=1, help="Largest number of POD modes.")] = DEFAULT_RANK,
    coarse: Annotated[
        Path | None,
        typer.Option(help="Model of a coarser mesh of the same face, from more snapshots, to begin from."),
    ] = None,
) -> None:
    """Train a reduced model from snapshots."""
    from risorius.commands.stage_display import stage_display
    from risorius.model import load
    from risorius.snapshot_file import SnapshotSet
    from risorius.training import reduce_snapshots

    begin_from = None if coarse is None else load(coarse)
    with stage_display() as stages:
        model = reduce_snapshots(SnapshotSet.load(snapshots), rank, begin_from, stages)
    model.save(output)
    typer.echo(describe(model, output))


def describe(model: ReducedModel, path: Path) -> str:
    """One line on a model that was just written."""
    from risorius.operating_point import most_accurate

    best = most_accurate(model.points)
    lengths = (best.overall.mean, best.overall.p95, best.overall.maximum)
    mean, p95, largest = (1e3 * length for length in lengths)
    return (
        f"{path}: {len(model.rest_vertices)} vertices, {model.rank} coordinates; held-out error of "
        f"{best.setting.method} mean {mean:.3f} mm, p95 {p95:.3f} mm, max {largest:.2f} mm"
    )
