"""How much a frame may cost, or how far off it may be, and which operating point that buys."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from pydantic import BaseModel, ConfigDict, field_validator

from risorius.errors import InputError


class Budget(BaseModel):
    """What a user asks of every frame.

    time: seconds, kept on 99 % of frames. error: metres; on 95 % of frames no vertex is further off from the full
    model. With both, the fastest operating point that meets both is taken. Raises InputError unless they are positive.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    time: float | None = None
    error: float | None = None

    @field_validator("time", "error")
    @classmethod
    def _positive(cls, value: float | None) -> float | None:
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise InputError(f"budget: {value:g} given; give a positive time in seconds, a positive error in metres")
        return value

    def __str__(self) -> str:
        asked = [] if self.time is None else [f"{1e3 * self.time:g} ms"]
        asked += [] if self.error is None else [f"{1e3 * self.error:g} mm"]
        return " and ".join(asked)


@dataclass(frozen=True)
class Offer:
    """What a frame costs and gives at an operating point.

    seconds: kept on 99 % of frames. frame_error: metres, no vertex is further off on 95 % of frames. p95: metres, no
    more than 5 % of all vertices are further off; it ranks the points, as the other is that of the few worst frames.
    """

    seconds: float
    frame_error: float
    p95: float


@dataclass(frozen=True)
class Choice:
    """position: of the offer that was taken; met: whether it keeps the budget."""

    position: int
    met: bool


def choose(offers: Sequence[Offer], budget: Budget) -> Choice:
    """Return the fastest that meets the error asked for, or the most accurate that meets the time.

    Time comes first: where none keeps it, the fastest is taken, and where none in time meets the error, the most
    accurate of those.
    """
    numbers = range(len(offers))
    in_time = [k for k in numbers if budget.time is None or offers[k].seconds <= budget.time]
    if not in_time:
        return Choice(min(numbers, key=lambda k: offers[k].seconds), met=False)
    if budget.error is not None:
        enough = [k for k in in_time if offers[k].frame_error <= budget.error]
        if enough:
            return Choice(min(enough, key=lambda k: offers[k].seconds), met=True)
    return Choice(min(in_time, key=lambda k: offers[k].p95), met=budget.error is None)
