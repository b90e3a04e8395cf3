"""What several commands are told: `--set NAME=WEIGHT`, of an input or a muscle, and `--scene FILE`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from risorius.errors import InputError

if TYPE_CHECKING:
    from risorius.engine import Engine
    from risorius.inputs import InputTable

SceneFile = Annotated[
    Path | None, typer.Option("--scene", help="Scene file (YAML): what the face has to show; everything unless given.")
]


def engine_for(model: Path, scene: Path | None) -> Engine:
    """Engine of a model file for a scene file."""
    from risorius.engine import Engine
    from risorius.model import load
    from risorius.scene import Scene

    wanted = Scene() if scene is None else Scene.load(scene)  # the quick check first
    return Engine(load(model), wanted)


def parse_settings(settings: Sequence[str]) -> dict[str, float]:
    """Weights by name; raises InputError for what is not NAME=WEIGHT and for a name that is set twice."""
    values: dict[str, float] = {}
    for setting in settings:
        name, sign, text = setting.partition("=")
        try:
            value = float(text)
        except ValueError:
            sign = ""
        if not (name and sign):
            raise InputError(f"--set {setting}: not NAME=WEIGHT; write for example --set AU12=0.8")
        if name in values:
            raise InputError(f"--set {setting}: {name} is set twice; give it one weight")
        values[name] = value
    return values


def split_muscles(values: Mapping[str, float], table: InputTable) -> tuple[dict[str, float], dict[str, float]]:
    """Weights of inputs and activations of muscles; a name that is both, or neither, counts as an input."""
    known = set(table.muscle_aliases) - set(table.aliases)
    muscles = {name: value for name, value in values.items() if name in known}
    return {name: value for name, value in values.items() if name not in muscles}, muscles
