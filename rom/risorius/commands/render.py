"""`risorius render`: a picture of the face."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from risorius.commands.settings import parse_settings, split_muscles
from risorius.errors import InputError


def render(
    model: Annotated[Path, typer.Argument(help="Model file.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Picture to write, .png.")],
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=WEIGHT", help="Weight of an input or a muscle; may be given often."),
    ] = None,
    view: Annotated[str, typer.Option(help="front, three-quarter or side.")] = "three-quarter",
    size: Annotated[str, typer.Option(help="Width and height in pixels.")] = "900x900",
) -> None:
    """Draw the face with given weights to a PNG file."""
    if output.suffix.lower() != ".png":
        raise InputError(f"{output}: pictures are written as PNG; give a name that ends in .png")
    values = parse_settings(settings or ())
    pixels = _pixels(size)
    from risorius.engine import Engine
    from risorius.model import load
    from risorius.picture import draw_face, save_png

    engine = Engine(load(model))
    inputs, muscles = split_muscles(values, engine.model.inputs)
    frame = engine.evaluate(inputs, muscles=muscles)
    picture = draw_face(
        frame.vertices, engine.triangles, view=view, size=pixels, keep_in_view=engine.model.rest_vertices
    )
    save_png(output, picture)
    typer.echo(f"{output}: {engine.model.name}, {frame.method}, error up to {1e3 * frame.error:.2g} mm")


def _pixels(size: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d+)x(\d+)", size)
    if not match:
        raise InputError(f"--size {size}: not WIDTHxHEIGHT in pixels; write for example --size 900x900")
    return int(match[1]), int(match[2])
