"""Named expressions and single moves as action-unit weights, and a loop that plays those a model can make."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from risorius.errors import InputError
from risorius.inputs import without_side

# FACS scores intensity in five ordinal steps, A (trace) to E (maximum). Equal steps of weight are our convention; a
# unit without a letter is taken at D.
TRACE, SLIGHT, MARKED, SEVERE, MAXIMUM = 0.2, 0.4, 0.6, 0.8, 1.0

_EASE = 0.35  # share of a turn spent easing in, and again easing out


@dataclass(frozen=True)
class Expression:
    """A name and weights in [0, 1] of inputs by their unsided name."""

    name: str
    weights: Mapping[str, float]


def _of_units(name: str, *numbers: int, weight: float = SEVERE, **others: float) -> Expression:
    return Expression(name, {f"AU{number}": weight for number in numbers} | others)


EMOTIONS: tuple[Expression, ...] = (
    _of_units("happiness", 6, 12),
    _of_units("surprise", 1, 2, 26, AU5=SLIGHT),
    _of_units("sadness", 1, 4, 15),
    _of_units("anger", 4, 5, 7, 23),
    _of_units("fear", 1, 2, 4, 5, 7, 20, 26),
    _of_units("disgust", 9, 15, 16),
)
"""Prototypical emotions: 6+12, 1+2+5B+26, 1+4+15, 4+5+7+23, 1+2+4+5+7+20+26 and 9+15+16.

Source: EMFACS-7, Emotional Facial Action Coding System, W. V. Friesen and P. Ekman, 1983.
"""

MOVES: tuple[Expression, ...] = (
    _of_units("brow raise", 1, 2, weight=MAXIMUM),
    _of_units("brow lower", 4, weight=MAXIMUM),
    _of_units("nose wrinkle", 9, weight=MAXIMUM),
    _of_units("smile", 12, weight=MAXIMUM),
    _of_units("lip corner depress", 15, weight=MAXIMUM),
    _of_units("lower lip depress", 16, weight=MAXIMUM),
    _of_units("chin raise", 17, weight=MAXIMUM),
    _of_units("lip pucker", 18, weight=MAXIMUM),
    _of_units("lip stretch", 20, weight=MAXIMUM),
    _of_units("jaw drop", 26, weight=MAXIMUM),
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
