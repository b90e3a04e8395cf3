"""`risorius gauntlet`: hard cases for a model."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def gauntlet(
    model: Annotated[Path, typer.Argument(help="Model file.")],
    as_json: Annotated[bool, typer.Option("--json", help="Machine-readable output.")] = False,
    full_model: Annotated[
        str | None, typer.Option(help="Anatomy (folder, file or builtin) whose full model is put to hard solves too.")
    ] = None,
) -> None:
    """Put a model to hard cases: exits 1 when a verdict does not hold. Effects that it lacks are not applicable."""
    from rich.console import Console
    from rich.progress import track

    from risorius.errors import Error
    from risorius.gauntlet import all_cases, run
    from risorius.gauntlet.full_model import hard_solves
    from risorius.gauntlet.run import FAILED
    from risorius.gauntlet.table import as_json as to_json
    from risorius.gauntlet.table import as_table
    from risorius.model import load

    loaded, cases = load(model), all_cases()
    errors = Console(stderr=True)
    results = list(track(run(loaded, cases), "reduced model", len(cases), console=errors, transient=True))
    if full_model is not None:
        results += track(hard_solves(full_model), "full model", console=errors, transient=True)
    if as_json:
        typer.echo(to_json(loaded.name, results))
    else:
        Console(highlight=False).print(as_table(results))
    failed = [one.name for one in results if one.outcome == FAILED]
    if failed:
        raise Error(f"gauntlet: {len(failed)} of {len(results)} cases failed: {', '.join(failed)}")
