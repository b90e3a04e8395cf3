"""Loads that follow those asked for: y' = (asked - y) / tau, solved exactly for what is linear in time."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numba
import numpy as np

from risorius.effects.effect import UPRIGHT, Surroundings, Touch
from risorius.jaw import FloatArray

NEGLIGIBLE = 1e-6  # newtons, or metres per second squared: a load that has ended is then gone


@numba.njit(cache=True)
def lag(step, times, before, after, lagged):  # type: ignore[no-untyped-def]
    """Take loads (k,) that lag by times (k,) on by a step in which those asked for go from `before` to `after`."""
    for k in range(len(lagged)):
        ahead = times[k] * (after[k] - before[k]) / step
        lagged[k] = after[k] - ahead + math.exp(-step / times[k]) * (lagged[k] - before[k] + ahead)


class OutsideLoads:
    """Gravity, as its change from upright, and touches, with a lag of tau seconds."""

    def __init__(self, tau: float) -> None:
        self._times = np.full(3, tau)
        self._asked: dict[int | None, FloatArray] = {}
        self._lagged: dict[int | None, FloatArray] = {}

    def restart(self) -> None:
        """Forget what acted before."""
        self._asked, self._lagged = {}, {}

    def take(self, surroundings: Surroundings, step: float | None) -> Surroundings:
        """Return what acts a step after what acted before; without a step, what is asked for."""
        asked = _by_place(surroundings)
        if step is None or not (asked or self._lagged):
            self._asked, self._lagged = asked, {place: load.copy() for place, load in asked.items()}
            return surroundings
        for place in asked.keys() | self._lagged.keys():
            before, after = self._asked.get(place, _NOTHING), asked.get(place, _NOTHING)
            lag(step, self._times, before, after, self._lagged.setdefault(place, np.zeros(3)))
            if place not in asked and np.abs(self._lagged[place]).max() < NEGLIGIBLE:
                del self._lagged[place]
        self._asked = asked
        return _surroundings(self._lagged, step)


_NOTHING = np.zeros(3)


def _by_place(surroundings: Surroundings) -> dict[int | None, FloatArray]:
    """Loads by the vertex they act on, that of gravity under None."""
    found: dict[int | None, FloatArray] = {}
    if surroundings.gravity is not None:
        found[None] = surroundings.gravity - UPRIGHT
    for touch in surroundings.touches:
        found[touch.vertex] = found.get(touch.vertex, _NOTHING) + touch.force
    return found


def _surroundings(loads: Mapping[int | None, FloatArray], step: float) -> Surroundings:
    gravity = loads[None] + UPRIGHT if None in loads else None
    touches = tuple(Touch(place, load.copy()) for place, load in loads.items() if place is not None)
    return Surroundings(step, gravity, touches)
