"""`risorius info`: what is in a model file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.table import Table

    from risorius.model import ReducedModel


def info(
    model: Annotated[Path, typer.Argument(help="Model file.")],
    as_json: Annotated[bool, typer.Option("--json", help="Machine-readable output.")] = False,
) -> None:
    """Show what a model understands, how accurate it is and where it comes from."""
    from dataclasses import asdict

    from rich.console import Console

    from risorius.inputs import without_side
    from risorius.model import load

    loaded = load(model)
    if as_json:
        content = {
            "name": loaded.name,
            "vertices": len(loaded.rest_vertices),
            "triangles": len(loaded.triangles),
            "coloured": len(loaded.colours) > 0,
            "companions": {
                name: {"vertices": len(thing.points), "triangles": len(thing.triangles), "moves_with": thing.moves_with}
                for name, thing in loaded.companions.items()
            },
            "rank": loaded.rank,
            "inputs": loaded.inputs.names,
            "muscles": loaded.inputs.muscles,
            "operating_points": [asdict(point) for point in loaded.points],
            "provenance": loaded.provenance,
        }
        typer.echo(json.dumps(content, indent=2))
        return
    console = Console(soft_wrap=True, highlight=False)
    coloured = " with colours" if len(loaded.colours) else ""
    console.print(
        f"[bold]{loaded.name}[/bold]: {len(loaded.rest_vertices)} vertices{coloured}, "
        f"{len(loaded.triangles)} triangles, {loaded.rank} coordinates ({loaded.lifts} of them of jaw and lids)"
    )
    if loaded.companions:
        seen = (
            f"{name} ({len(thing.points)} vertices, {thing.moves_with})" for name, thing in loaded.companions.items()
        )
        console.print("seen with it: " + ", ".join(seen), markup=False)
    console.print("inputs: " + ", ".join(dict.fromkeys(without_side(name) for name in loaded.inputs.names)))
    console.print("muscles: " + ", ".join(dict.fromkeys(without_side(name) for name in loaded.inputs.muscles)))
    console.print(_accuracy(loaded))
    for key, value in sorted(loaded.provenance.items()):
        console.print(f"{key}: {value}", markup=False)


def _accuracy(model: ReducedModel) -> Table:
    """Operating points, and the errors of each by kind of held-out input."""
    from rich.table import Table

    table = Table(title=f"error against the full model, {model.provenance.get('held_out', '?')} held-out snapshots, mm")
    table.add_column("operating point")
    for column in ("mean", "p95", "max", "95 % of\nframes", "relative\nL2 %", "ms"):
        table.add_column(column, justify="right", no_wrap=True)
    for point in model.points:
        table.add_row(str(point.setting), *[""] * 5, f"{1e3 * point.seconds.median:.3f}")
        for kind, found in point.errors.items():
            lengths = (found.mean, found.p95, found.maximum, found.frame)
            figures = (*(1e3 * length for length in lengths), 100 * found.relative)
            table.add_row(f"  {kind}", *(f"{figure:.3f}" for figure in figures))
    return table
