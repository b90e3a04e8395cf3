"""`risorius info`: what is in a model file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer


def info(
    model: Annotated[Path, typer.Argument(help="Model file.")],
    as_json: Annotated[bool, typer.Option("--json", help="Machine-readable output.")] = False,
) -> None:
    """Show what a model understands, how accurate it is and where it comes from."""
    from dataclasses import asdict

    from rich.console import Console
    from rich.table import Table

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
            "accuracy": {name: asdict(accuracy) for name, accuracy in loaded.accuracy.items()},
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
    table = Table(title=f"error against the full model, {loaded.provenance.get('held_out', '?')} held-out snapshots")
    for column in ("evaluator", "mean mm", "p95 mm", "max mm", "relative L2 %"):
        table.add_column(column, justify="left" if column == "evaluator" else "right")
    for name, accuracy in loaded.accuracy.items():
        lengths = (accuracy.mean, accuracy.p95, accuracy.maximum)
        table.add_row(name, *(f"{1e3 * value:.3f}" for value in lengths), f"{100 * accuracy.relative:.2f}")
    console.print(table)
    for key, value in sorted(loaded.provenance.items()):
        console.print(f"{key}: {value}", markup=False)
