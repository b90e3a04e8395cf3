"""`risorius snapshots`: solve equilibria of the full model."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from risorius_offline.commands.effects import Contact, ForceLength, Prestress
from risorius_offline.commands.installed import require_offline
from risorius_offline.commands.source import load

if TYPE_CHECKING:
    from risorius.snapshot_file import SnapshotSet
    from risorius_offline.effect_choice import EffectChoice

DEFAULT_COUNT, DEFAULT_HELD_OUT = 120, 24

Count = Annotated[int, typer.Option("--snapshots", min=1, help="Training snapshots; all single actions are added.")]
HeldOut = Annotated[int, typer.Option(min=1, help="Snapshots to measure accuracy on; never trained with.")]
Workers = Annotated[int, typer.Option(min=0, help="Processes; 0 takes one per core.")]
Seed = Annotated[int, typer.Option(min=0, help="Seed of the sampling design.")]


def snapshots(
    source: Annotated[str, typer.Argument(help="'builtin', an import folder, or an anatomy file.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Snapshot file to write.")] = Path("snapshots.h5"),
    count: Count = DEFAULT_COUNT,
    held_out: HeldOut = DEFAULT_HELD_OUT,
    workers: Workers = 0,
    seed: Seed = 0,
    contact: Contact = False,
    prestress: Prestress = 0.0,
    force_length: ForceLength = False,
) -> None:
    """Solve snapshots; a run that was stopped goes on where it was when started again."""
    require_offline("solving snapshots")
    from risorius_offline.effect_choice import EffectChoice

    effects = EffectChoice(contact=contact, prestress=prestress, force_length=force_length)
    solve(source, output, count, held_out, workers, seed, effects)


def solve(
    source: str, output: Path, count: int, held_out: int, workers: int, seed: int, effects: EffectChoice
) -> SnapshotSet:
    """Solve, write and return snapshots of a source, with a progress bar; failed samples are listed at the end."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    from risorius_offline.sampling import design
    from risorius_offline.snapshots import solve_design

    anatomy = load(source)
    plan = design(anatomy.inputs, count, held_out, seed)
    console = Console(stderr=True, soft_wrap=True, highlight=False)
    columns = ("snapshots", BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[rate]}"), TimeRemainingColumn())
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("snapshots", total=len(plan.parameters), rate="")
        told = -1

        def show(done: int, failed: int, total: int) -> None:
            nonlocal told
            speed = bar.tasks[task].speed
            rate = f"{speed:.1f}/s" if speed else ""
            bar.update(task, completed=done, rate=rate + (f", {failed} failed" if failed else ""))
            tenth = 10 * done // total
            if tenth > told and not console.is_terminal:  # a log file gets ten plain lines instead of a bar
                told = tenth
                console.print(f"snapshots {done}/{total}{f', {failed} failed' if failed else ''}", markup=False)

        result = solve_design(anatomy, plan, output, workers or os.cpu_count() or 1, show, effects)
    for failure in result.failures:
        console.print(f"not solved: {failure}", markup=False)
    console.print(f"{output}: {len(result.parameters)} snapshots, {len(result.failures)} not solved", markup=False)
    return result
