"""Sub-commands of the runtime core, one file each. Heavy imports stay inside the functions."""

from __future__ import annotations

import typer

from risorius.commands.gauntlet import gauntlet
from risorius.commands.info import info
from risorius.commands.reduce import reduce
from risorius.commands.render import render
from risorius.commands.report import report
from risorius.commands.scene import app as scene
from risorius.commands.view import view


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    for command in (reduce, info, report, gauntlet, render, view):
        app.command()(command)
    app.add_typer(scene, name="scene")
