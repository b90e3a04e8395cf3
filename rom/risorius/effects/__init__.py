"""Effects: what a scene may call for besides muscles that pull, each absent unless it does.

A new effect is one file here with a class that satisfies `Effect`, one line in `EFFECTS`, and a field of `Scene`.
"""

from __future__ import annotations

from risorius.effects.contact import Contact
from risorius.effects.effect import Effect, Surroundings, Touch
from risorius.effects.gravity import Gravity
from risorius.effects.inertia import Inertia
from risorius.effects.touch import TouchResponse

__all__ = ["EFFECTS", "Effect", "Surroundings", "Touch"]

EFFECTS: dict[str, type[Effect]] = {kind.name: kind for kind in (Inertia, Gravity, TouchResponse, Contact)}
