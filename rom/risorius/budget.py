"""How much a frame may cost, or how far off it may be, and which operating point that buys."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
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
class Choice:
    """position: of the operating point that was taken; met: whether the budget is."""

    position: int
    met: bool


def choose(seconds: npt.ArrayLike, errors: Sequence[float], budget: Budget) -> Choice:
    """Return the fastest point that meets the error asked for; where none is, the most accurate that meets the time.

    Of points (n,) of which frames take so many seconds and are so many metres off. Where no point meets the budget,
    the one that exceeds it by the smallest factor.
    """
    costs, distances = np.asarray(seconds, dtype=float), np.asarray(errors, dtype=float)
    excess = np.maximum(costs / (budget.time or math.inf), distances / (budget.error or math.inf))
    met = excess <= 1.0
    if not met.any():
        return Choice(int(excess.argmin()), met=False)
    rank = np.lexsort((distances, costs) if budget.error else (costs, distances))
    return Choice(int(next(k for k in rank if met[k])), met=True)
