"""`risorius train`: from an anatomy to a reduced model in one go."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from risorius.commands.reduce import DEFAULT_RANK, describe
from risorius_offline.commands.effects import Contact, ForceLength, Prestress, contact_of
from risorius_offline.commands.installed import require_offline
from risorius_offline.commands.run_options import (
    DEFAULT_COUNT,
    DEFAULT_HELD_OUT,
    Adaptive,
    Count,
    Derivatives,
    HeldOut,
    RunOptions,
    Scheduler,
    Seed,
    TargetError,
    Workers,
)
from risorius_offline.source_names import SOURCE_HELP


def train(
    source: Annotated[str, typer.Argument(help=SOURCE_HELP)],
    output: Annotated[Path, typer.Option("--output", "-o", help="Model file to write.")] = Path("model.h5"),
    count: Count = DEFAULT_COUNT,
    held_out: HeldOut = DEFAULT_HELD_OUT,
    rank: Annotated[int, typer.Option(min=1, help="Largest number of POD modes.")] = DEFAULT_RANK,
    seed: Seed = 0,
    adaptive: Adaptive = False,
    target_error: TargetError = 0.0,
    derivatives: Derivatives = True,
    contact: Contact = None,
    prestress: Prestress = 0.0,
    force_length: ForceLength = False,
    workers: Workers = 0,
    scheduler: Scheduler = None,
) -> None:
    """Solve snapshots and train a reduced model. The snapshots are kept beside the model, as MODEL.snapshots.h5."""
    require_offline("training")
    from risorius.commands.stage_display import stage_display
    from risorius.training import reduce_snapshots
    from risorius_offline.commands.solving import solve

    touching = contact_of(source, contact)
    options = RunOptions(count, held_out, seed, adaptive, target_error, derivatives, touching, prestress, force_length)
    snapshots = solve(source, output.with_suffix(".snapshots.h5"), options, workers, scheduler, json_lines=False)
    with stage_display() as stages:
        model = reduce_snapshots(snapshots, rank, stages=stages)
    model.save(output)
    typer.echo(describe(model, output))
