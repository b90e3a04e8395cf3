"""`risorius scene`: what a scene leaves of a model, and which one is enough."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from risorius.commands.settings import SceneFile, engine_for

app = typer.Typer(help="Scenes: what a face has to show.", no_args_is_help=True)


@app.command()
def show(
    model: Annotated[Path, typer.Argument(help="Model file.")],
    scene: SceneFile = None,
) -> None:
    """Print every field of a scene as YAML, with what it leaves of the model."""
    from risorius.effects import EFFECTS
    from risorius.model import load

    whole, engine = load(model), engine_for(model, scene)
    left = engine.model
    known = {"jaw": left.poses.jaw is not None, **{name: name in engine.effects for name in EFFECTS}}
    typer.echo(engine.scene.model_copy(update=known).yaml(every_field=True), nl=False)
    for what, ours, theirs in (
        ("inputs", len(left.inputs.names), len(whole.inputs.names)),
        ("muscles", len(left.inputs.muscles), len(whole.inputs.muscles)),
        ("coordinates", left.rank, whole.rank),
        ("vertices", len(left.rest_vertices), len(whole.rest_vertices)),
        ("triangles", len(left.triangles), len(whole.triangles)),
    ):
        typer.echo(f"# {what}: {ours} of {theirs}")
    typer.echo(f"# runs: {engine.point.setting}")


@app.command()
def suggest(
    timeline: Annotated[Path, typer.Argument(help="CSV file: of OpenFace, or with columns named as inputs.")],
    model: Annotated[Path, typer.Argument(help="Model file.")],
    max_error: Annotated[float, typer.Option(help="Millimetres that no vertex may be further off in any frame.")],
    scene: SceneFile = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Scene file to write; printed as well.")] = None,
) -> None:
    """Print the cheapest scene that shows a timeline as everything (or as --scene) does, within an error."""
    from risorius.model import load
    from risorius.scene import Scene
    from risorius.suggesting import suggest as found_for
    from risorius.timeline import Timeline

    base = Scene() if scene is None else Scene.load(scene)
    loaded = load(model)
    played = Timeline.read(timeline, loaded.inputs)
    found = found_for(loaded, played, 1e-3 * max_error, base)
    if output is not None:
        found.scene.save(output)
    typer.echo(
        f"# {found.error * 1e3:.3f} mm at most over {len(played.weights)} frames of {played.name}; "
        f"{1e6 * found.seconds:.0f} us a frame instead of {1e6 * found.whole:.0f}"
    )
    typer.echo(found.scene.yaml(), nl=False)
