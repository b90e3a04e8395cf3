"""`risorius render`: a picture of the face, or a contact sheet."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from risorius.commands.settings import SceneFile, engine_for, parse_settings, split_muscles
from risorius.errors import InputError

if TYPE_CHECKING:
    from risorius.engine import Engine


def render(
    model: Annotated[Path, typer.Argument(help="Model file.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Picture to write, .png.")],
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=WEIGHT", help="Weight of an input or a muscle; may be given often."),
    ] = None,
    view: Annotated[str | None, typer.Option(help="front, three-quarter (unless given) or side.")] = None,
    size: Annotated[str | None, typer.Option(help="Pixels: 900x900, or 240x280 each on a sheet, unless given.")] = None,
    sheet: Annotated[str | None, typer.Option(help="Contact sheet: units, expressions, jaw or muscles.")] = None,
    scene: SceneFile = None,
) -> None:
    """Draw the face with given weights, or a contact sheet of many faces, to a PNG file."""
    if output.suffix.lower() != ".png":
        raise InputError(f"{output}: pictures are written as PNG; give a name that ends in .png")
    if sheet is None:
        values, pixels = parse_settings(settings or ()), _pixels(size or "900x900")
        _render_face(engine_for(model, scene), output, values, view or "three-quarter", pixels)
    elif settings or view:
        raise InputError(f"--sheet {sheet}: weights and views are the sheet's own; leave --set and --view out")
    else:
        _render_sheet(model, scene, output, sheet, _pixels(size or "240x280"))


def _render_face(engine: Engine, output: Path, values: dict[str, float], view: str, size: tuple[int, int]) -> None:
    from risorius.companion import posed_companions
    from risorius.picture import draw_face, save_png

    inputs, muscles = split_muscles(values, engine.model.inputs)
    frame = engine.evaluate(inputs, muscles=muscles)
    picture = draw_face(
        frame.vertices,
        engine.triangles,
        view=view,
        size=size,
        keep_in_view=engine.model.rest_vertices,
        colours=engine.model.colours,
        companions=posed_companions(engine.model.companions, engine.model.poses, frame.coordinates),
    )
    save_png(output, picture)
    typer.echo(f"{output}: {engine.model.name}, {frame.method}, error up to {1e3 * frame.error:.2g} mm")


def _render_sheet(model: Path, scene: Path | None, output: Path, sheet: str, size: tuple[int, int]) -> None:
    from risorius.contact_sheet import draw_sheet
    from risorius.picture import save_png
    from risorius.sheets import SHEETS, faces_of

    if sheet not in SHEETS:
        raise InputError(f"--sheet {sheet}: not known; choose from: {', '.join(SHEETS)}")
    engine = engine_for(model, scene)
    faces = faces_of(sheet, engine.model.inputs)
    save_png(output, draw_sheet(engine, faces, size))
    typer.echo(f"{output}: {engine.model.name}, {len(faces)} faces")


def _pixels(size: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d+)x(\d+)", size)
    if not match:
        raise InputError(f"--size {size}: not WIDTHxHEIGHT in pixels; write for example --size 900x900")
    return int(match[1]), int(match[2])
