"""The table of a dry run."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from risorius_offline.cost import Cost


def show_cost(cost: Cost, *, json_lines: bool) -> None:
    """Print what a run would take, as a table, or as a line of JSON in seconds and bytes."""
    if json_lines:
        totals = {"seconds": cost.seconds, "disk": cost.disk, "memory": cost.memory}
        typer.echo(json.dumps({"event": "estimate", **asdict(cost), **totals}))
        return
    rows = {
        "snapshots to solve": f"{cost.samples}, with {cost.workers} workers",
        "time": f"{cost.seconds / 60:.1f} min, {cost.seconds_each:.2f} s each",
        "memory": f"{_size(cost.memory)}, {_size(cost.memory_each)} a worker; {_size(cost.free_memory)} available here",
        "disk": f"{_size(cost.disk)}, {_size(cost.disk_each)} each; {_size(cost.free_disk)} free",
    }
    for name, text in rows.items():
        typer.echo(f"{name:20}{text}")
    if cost.disk > cost.free_disk:
        typer.echo("The disk is too small: free some space, take another, or give --no-derivatives.")


def _size(count: int) -> str:
    return f"{count / 1e9:.2f} GB" if count > 1e8 else f"{count / 1e6:.2f} MB"
