"""How hard cases are put together: parameters, effects, and a case of an anatomy with effects."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from risorius.mechanics.fibres import PROPORTIONAL
from risorius_offline.anatomy import Anatomy
from risorius_offline.discretisation import Discretisation
from risorius_offline.effects import Effect
from risorius_offline.effects.gravity import UPRIGHT, gravity
from risorius_offline.effects.skin_prestress import SkinPrestress
from risorius_offline.full_model import FullModel
from tests.offline.hard_attempts import HardCase, Parameters

AT_ONCE = {"smallest_step": 1.0}


def at(*values: float) -> Parameters:
    """These parameters, unchecked."""
    return lambda inputs: np.array(values)


def every_muscle(activation: float) -> Parameters:
    return lambda inputs: np.where([name in inputs.muscles for name in inputs.parameters], activation, 0.0)


def driven(muscles: Mapping[str, float] | None = None, **weights: float) -> Parameters:
    """Parameters of named inputs, and of muscles."""
    return lambda inputs: inputs.to_parameters(inputs.weights(weights), muscles)


def case(
    name: str,
    anatomy: Callable[[], Anatomy],
    parameters: Parameters,
    *effects: Callable[[Anatomy], Effect],
    law: int = PROPORTIONAL,
    **others: Any,
) -> HardCase:
    """A case of an anatomy with effects."""

    def build() -> FullModel:
        built = anatomy()
        return FullModel(built, [effect(built) for effect in effects], fibre_law=law)

    return HardCase(name, build, parameters, **others)


def accelerated(*acceleration: float) -> Callable[[Anatomy], Effect]:
    """Gravity of a body taken upright, m/s2."""
    return lambda a: gravity(Discretisation(a.points, a.cells), acceleration, UPRIGHT)


def tense(stress: float) -> Callable[[Anatomy], Effect]:
    """Pre-stress of the skin, pascals."""
    return lambda a: SkinPrestress(a.points, a.skin, stress)
