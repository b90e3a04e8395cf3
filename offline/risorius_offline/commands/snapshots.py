"""`risorius snapshots`: solve equilibria of the full model."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from risorius_offline.commands.effects import Contact, ForceLength, Prestress, contact_of
from risorius_offline.commands.installed import require_offline
from risorius_offline.commands.run_options import (
    DEFAULT_COUNT,
    DEFAULT_HELD_OUT,
    Adaptive,
    Count,
    Derivatives,
    DryRun,
    HeldOut,
    Json,
    Resume,
    RunOptions,
    Scheduler,
    Seed,
    TargetError,
    Workers,
)
from risorius_offline.source_names import SOURCE_HELP


def snapshots(
    source: Annotated[str, typer.Argument(help=SOURCE_HELP)],
    output: Annotated[Path, typer.Option("--output", "-o", help="Snapshot file to write.")] = Path("snapshots.h5"),
    count: Count = DEFAULT_COUNT,
    held_out: HeldOut = DEFAULT_HELD_OUT,
    seed: Seed = 0,
    adaptive: Adaptive = False,
    target_error: TargetError = 0.0,
    derivatives: Derivatives = True,
    contact: Contact = None,
    prestress: Prestress = 0.0,
    force_length: ForceLength = False,
    workers: Workers = 0,
    scheduler: Scheduler = None,
    resume: Resume = False,
    json_lines: Json = False,
    dry_run: DryRun = False,
) -> None:
    """Solve snapshots; a run that was stopped goes on where it was when started again, and a longer one adds to it."""
    require_offline("solving snapshots")
    from risorius_offline.commands.solving import show_estimate, solve, stored_options

    touching = contact_of(source, contact)
    options = RunOptions(count, held_out, seed, adaptive, target_error, derivatives, touching, prestress, force_length)
    if resume:
        options = stored_options(output)
    if dry_run:
        show_estimate(source, output, options, workers, scheduler, json_lines=json_lines)
        return
    solve(source, output, options, workers, scheduler, json_lines=json_lines)
