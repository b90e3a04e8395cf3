"""What a scene calls for; an effect that is off costs nothing."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class Scene(BaseModel):
    """Effects of one scene. `Scene()` is everything the model was trained for.

    nonlinear: muscles interact; off is superposition (7.8), exact for single actions at full weight only.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    nonlinear: bool = True
