"""Named expressions and single moves as action-unit weights, and a loop that plays those a model can make."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from risorius.errors import InputError
from risorius.inputs import without_side
from risorius.intensities import MAXIMUM, SEVERE, TRACE, action_units

_EASE = 0.35  # share of a turn spent easing in, and again easing out


@dataclass(frozen=True)
class Expression:
    """A name and weights in [0, 1] of inputs by their unsided name."""

    name: str
    weights: Mapping[str, float]


@dataclass(frozen=True)
class MuscleSet:
    """A name and activations in [0, 1] of muscles, one-sided or by their unsided name."""

    name: str
    activations: Mapping[str, float]

    def within(self, muscles: Sequence[str]) -> dict[str, float]:
        """Return the activations of those that are among a model's `muscles`."""
        known = set(muscles) | {without_side(name) for name in muscles}
        return {name: activation for name, activation in self.activations.items() if name in known}


EMOTIONS: tuple[Expression, ...] = (
    Expression("happiness", action_units("6+12")),
    Expression("surprise", action_units("1+2+5B+26")),
    Expression("sadness", action_units("1E+4B+15")),
    Expression("anger", action_units("4E+5B+7D+17C+24E")),
    Expression("fear", action_units("1E+2C+4C+5E+7B+20E+21D+25D+26C")),
    Expression("disgust", action_units("9+15+16")),
)
"""Prototypical emotions.

Units: EMFACS-7, Emotional Facial Action Coding System, W. V. Friesen and P. Ekman, 1983; anger in its closed-mouth form
with 17 and 24, and 25 in fear, whose lips are parted: FACS Investigator's Guide, P. Ekman, W. V. Friesen and J. C.
Hager, 2002; FACS 2002 gives 20 platysma beside risorius, here 21. Intensities other than that of surprise are ours.
"""

_PARTS = ("orbicularis_oris_marginalis", "orbicularis_oris_peripheralis")
# In one piece, divided into marginal and peripheral, and into upper and lower as well: a model has one of the three.
_ORBICULARIS_ORIS = dict.fromkeys(
    ("orbicularis_oris", *_PARTS, *(f"{part}_{lip}" for part in _PARTS for lip in ("superior", "inferior"))), TRACE
)

FIGURES: tuple[MuscleSet, ...] = (
    MuscleSet(
        "happiness of Figure 7.17",
        {"zygomaticus_major": SEVERE, "zygomaticus_minor": SEVERE, "risorius": SEVERE, **_ORBICULARIS_ORIS},
    ),
    MuscleSet(
        "disgust of Figure 7.18",
        {
            "depressor_anguli_oris_L": SEVERE,
            "depressor_labii_inferioris_L": SEVERE,
            "mentalis_L": SEVERE,
            "levator_labii_superioris_R": SEVERE,
            **_ORBICULARIS_ORIS,
        },
    ),
)
"""The seed's own happiness and disgust. It names the muscles; the activations are ours."""

MOVES: tuple[Expression, ...] = (
    Expression("brow raise", action_units("1E+2E")),
    Expression("brow lower", action_units("4E")),
    Expression("nose wrinkle", action_units("9E")),
    Expression("smile", action_units("12E")),
    Expression("lip corner depress", action_units("15E")),
    Expression("lower lip depress", action_units("16E")),
    Expression("chin raise", action_units("17E")),
    Expression("lip pucker", action_units("18E")),
    Expression("lip stretch", action_units("20E")),
    Expression("jaw drop", action_units("26E")),
)
"""One action unit each (the brow raise: both its parts) at full weight.

Source of the units' meaning: Facial Action Coding System, P. Ekman and W. V. Friesen, 1978.
"""


def possible_expressions(inputs: Sequence[str]) -> tuple[Expression, ...]:
    """Emotions, then moves, cut down to what `inputs` (names as in Engine.inputs) can do.

    What is left of two expressions may be the same; the first of them then stands for both. A model that can make none
    gets each of its inputs as a move of its own.
    """
    known = set(inputs) | {without_side(name) for name in inputs}
    found: list[Expression] = []
    for expression in EMOTIONS + MOVES:
        weights = {name: weight for name, weight in expression.weights.items() if name in known}
        if weights and all(weights != other.weights for other in found):
            found.append(Expression(expression.name, weights))
    if found:
        return tuple(found)
    return tuple(Expression(name, {name: MAXIMUM}) for name in dict.fromkeys(map(without_side, inputs)))


@dataclass(frozen=True)
class ExpressionLoop:
    """Expressions one after another, each eased in from rest and out again, without end.

    seconds_each: how long one turn lasts, seconds.
    """

    expressions: tuple[Expression, ...]
    seconds_each: float

    @property
    def period(self) -> float:
        """Seconds after which the loop repeats."""
        return self.seconds_each * len(self.expressions)

    def expression(self, seconds: float) -> Expression:
        """Return the expression whose turn it is."""
        return self.expressions[int(seconds / self.seconds_each) % len(self.expressions)]

    def weights(self, seconds: float) -> dict[str, float]:
        """Weights in [0, 1] at a time.

        Every name that the loop ever moves is in the result, so that a receiver that keeps what it is not told about
        returns to rest as well.
        """
        result = {name: 0.0 for expression in self.expressions for name in expression.weights}
        strength = _envelope(math.fmod(seconds, self.seconds_each) / self.seconds_each)
        for name, weight in self.expression(seconds).weights.items():
            result[name] = strength * weight
        return result


def expression_loop(inputs: Sequence[str], seconds_each: float = 2.0) -> ExpressionLoop:
    """Return the loop over `possible_expressions(inputs)`; raises InputError for no inputs or no time."""
    if not inputs:
        raise InputError("expression loop: the model has no inputs; train it with at least one muscle or a jaw")
    if not (math.isfinite(seconds_each) and seconds_each > 0.0):
        raise InputError(f"seconds_each: {seconds_each} given; give a positive number of seconds")
    return ExpressionLoop(possible_expressions(inputs), seconds_each)


def _envelope(phase: float) -> float:
    """Return the strength over one turn, phase in [0, 1): up, hold, down; the speed is zero at both ends."""
    rise = min(1.0, min(phase, 1.0 - phase) / _EASE)
    return rise * rise * (3.0 - 2.0 * rise)
