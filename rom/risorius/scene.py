"""What a scene calls for; an effect that is off costs nothing."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class Scene(BaseModel):
    """Effects of one scene. `Scene()` is everything the model was trained for.

    nonlinear: muscles interact; off is superposition (7.8), exact for single actions at full weight only.
    inertia, gravity, touch: docs/effects.md; None is on where the model has it, True is an InputError where it has not.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    nonlinear: bool = True
    inertia: bool | None = None
    gravity: bool | None = None
    touch: bool | None = None
