"""`risorius anatomy`: import and check an anatomy."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from risorius_offline.commands.installed import require_offline
from risorius_offline.commands.source import load
from risorius_offline.source_names import SOURCE_HELP


def anatomy(
    source: Annotated[str, typer.Argument(help=SOURCE_HELP)],
    output: Annotated[Path, typer.Option("--output", "-o", help="Anatomy file to write.")] = Path("face.h5"),
) -> None:
    """Import an anatomy, check it and write it as one file."""
    require_offline("risorius anatomy")
    from risorius_offline.full_model import FullModel

    loaded = load(source)
    FullModel(loaded)  # a muscle without tissue or an inverted cell shows here, before anything is written
    loaded.save(output)
    cells = ", ".join(f"{len(block.connectivity)} {block.cell_type}" for block in loaded.cells)
    typer.echo(f"{output}: {len(loaded.points)} nodes, {cells}, {len(loaded.muscles)} muscles")
