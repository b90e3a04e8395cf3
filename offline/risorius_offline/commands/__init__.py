"""Sub-commands of the offline part, one file each. Heavy imports stay inside the functions."""

from __future__ import annotations

import typer

from risorius_offline.commands.anatomy import anatomy
from risorius_offline.commands.snapshots import snapshots
from risorius_offline.commands.solve import solve
from risorius_offline.commands.train import train


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    for command in (train, anatomy, snapshots, solve):
        app.command()(command)
