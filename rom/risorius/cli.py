"""The `risorius` command: gathers the sub-commands of the installed packages and turns errors into one line."""

from __future__ import annotations

import sys
from importlib.metadata import entry_points

import typer
from rich.console import Console

from risorius.errors import Error

app = typer.Typer(
    name="risorius",
    help="Facial action units in, a physically deformed face out.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)


def main() -> None:
    """Entry point of the console script. Exits 2 for bad input, 1 for a failed run, 130 when interrupted."""
    for entry in sorted(entry_points(group="risorius.commands"), key=lambda entry: entry.name):
        entry.load()(app)
    try:
        app()
    except Error as error:
        Console(stderr=True, soft_wrap=True, highlight=False).print(f"risorius: {error}", markup=False)
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        sys.exit(130)
