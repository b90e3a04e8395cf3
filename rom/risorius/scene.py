"""What a scene calls for: what it leaves out is not there, and costs nothing."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import yaml
from pydantic import BaseModel, ConfigDict, ValidationError

from risorius.budget import Budget
from risorius.errors import FileFormatError, InputError
from risorius.storage import replaced_when_complete

Region = Literal["full", "mouth", "eyes", "brows"]
Output = Literal["vertices", "normals", "strain", "effort"]


class Scene(BaseModel):
    """What one scene calls for. `Scene()` is everything that the model was trained for; docs/scenes.md.

    nonlinear: muscles interact; off is superposition (7.8), exact for single actions at full weight only.
    jaw: the mandible moves. contact, inertia, gravity, touch: docs/effects.md. None is on where the model has it; True
    is an InputError where it has not.
    inputs: action units, poses or muscles that there are, by name; without a side both. None for all of the model.
    region: skin that there is: all, what muscles of mouth, eyes or brows move, or vertices by number.
    resolution: every vertex, or one for each point of the mesh that carries the skin.
    outputs: what a frame holds besides its vertices.
    budget: what a frame may cost; `Engine` may be given another one.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    nonlinear: bool = True
    jaw: bool | None = None
    contact: bool | None = None
    inertia: bool | None = None
    gravity: bool | None = None
    touch: bool | None = None
    inputs: tuple[str, ...] | None = None
    region: Region | tuple[int, ...] = "full"
    resolution: Literal["full", "carriers"] = "full"
    outputs: tuple[Output, ...] = ("vertices",)
    budget: Budget | None = None

    @classmethod
    def load(cls, path: str | Path) -> Scene:
        """Read a scene from YAML. Raises InputError that names file, field and value for anything but one."""
        path = Path(path)
        if not path.is_file():
            raise InputError(f"{path}: no such file; `risorius scene show MODEL` prints a scene to start from")
        try:
            content = yaml.safe_load(path.read_text(encoding="utf-8"))
        except (yaml.YAMLError, UnicodeDecodeError) as error:
            raise FileFormatError(f"{path}: not YAML: {' '.join(str(error).split())}") from error
        if content is None:
            return cls()
        if not isinstance(content, dict):
            raise InputError(f"{path}: holds a {type(content).__name__}; give fields of a scene, as `inputs: [AU12]`")
        try:
            return cls(**content)
        except ValidationError as error:
            raise InputError(f"{path}: {_first_fault(error)}") from error
        except InputError as error:
            raise InputError(f"{path}: {error}") from error

    def save(self, path: str | Path) -> None:
        """Write the scene as YAML: only what differs from `Scene()`."""
        with replaced_when_complete(Path(path)) as partial:
            partial.write_text(self.yaml(), encoding="utf-8")

    def yaml(self, *, every_field: bool = False) -> str:
        """Text of the scene in YAML, only what differs from `Scene()` unless every field is asked for."""
        fields = self.model_dump(mode="json", exclude_defaults=not every_field)
        return yaml.safe_dump(fields, sort_keys=False, default_flow_style=None) if fields else "{}\n"


def _first_fault(error: ValidationError) -> str:
    """Field, value and what is wrong; of a field with several kinds of values that which says most."""
    faults = error.errors(include_url=False)
    fault = min(faults, key=lambda one: one["type"] == "tuple_type")
    field, value = str(fault["loc"][0]), fault["input"]
    if fault["type"] == "extra_forbidden":
        return f"field {field!r} is not known; a scene has {', '.join(Scene.model_fields)}"
    return f"{field}: {_shown(value)}: {fault['msg'][:1].lower()}{fault['msg'][1:]}"


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
