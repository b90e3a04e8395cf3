"""Inputs at their ends: everything, antagonists, every action unit alone and with the jaw open."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from risorius.facs import ACTION_UNITS
from risorius.gauntlet.case import Ask, Bench, Case, asks
from risorius.jaw import FloatArray

LEVELS = (0.01, 0.1, 0.3, 0.6, 1.0)
SIDES = ("L", "R")
ANTAGONISTS = (
    ("AU1", "AU4"), ("AU2", "AU4"), ("AU5", "AU43"), ("AU6", "AU5"), ("AU9", "AU17"), ("AU10", "AU15"),
    ("AU12", "AU15"), ("AU12", "AU18"), ("AU20", "AU18"), ("AU20", "AU23"), ("AU22", "AU24"), ("AU16", "AU10"),
    ("AU17", "AU16"), ("AU26", "AU24"), ("AU27", "AU17"), ("AU14", "AU18"),
)  # fmt: skip


def extreme_cases() -> list[Case]:
    """Static frames, at several levels."""
    patterns: dict[str, Callable[[Bench], FloatArray]] = {
        "rest": lambda bench: np.zeros_like(bench.lower),
        "every input at 1": lambda bench: np.ones_like(bench.lower),
        "every input at its lowest": lambda bench: bench.lower,
        "every second input at 1": lambda bench: _alternating(bench),
        "every other second input at 1": lambda bench: 1.0 - _alternating(bench),
        "every input of the left at 1": partial(_ending, "_L"),
        "every input of the right at 1": partial(_ending, "_R"),
        "every pose at 1": lambda bench: _poses(bench, 1.0),
        "every pose at its lowest": lambda bench: np.where(_poses(bench, 1.0) > 0.0, bench.lower, 0.0),
        "every input but the poses at 1": lambda bench: 1.0 - _poses(bench, 1.0),
    }
    cases = [Case(name, "extremes", partial(_levels, pattern)) for name, pattern in patterns.items()]
    cases.append(Case("every muscle at 1, by name", "extremes", _muscles))
    for unit in ACTION_UNITS:
        cases.append(Case(unit, "extremes", partial(_named, {unit: 1.0})))
        open_too = {unit: 1.0, "jaw_open": 1.0}
        cases.append(Case(f"{unit} with the jaw open", "extremes", partial(_named, open_too)))
    for one, other in ANTAGONISTS:
        cases.append(Case(f"{one} against {other}", "extremes", partial(_named, {one: 1.0, other: 1.0})))
    for side, opposite in (SIDES, SIDES[::-1]):
        named = {f"AU12_{side}": 1.0, f"AU15_{opposite}": 1.0}
        cases.append(Case(f"AU12 of {side} against AU15 of {opposite}", "extremes", partial(_named, named)))
    return cases


def _levels(pattern: Callable[[Bench], FloatArray], bench: Bench) -> list[Ask]:
    return asks(level * pattern(bench) for level in LEVELS)


def _named(named: Mapping[str, float], bench: Bench) -> list[Ask]:
    weights = bench.weights(named)
    return asks(level * weights for level in LEVELS)


def _ending(ending: str, bench: Bench) -> FloatArray:
    return np.array([float(name.endswith(ending)) for name in bench.model.inputs.names])


def _alternating(bench: Bench) -> FloatArray:
    return np.array([float(number % 2) for number in range(len(bench.lower))])


def _poses(bench: Bench, weight: float) -> FloatArray:
    return np.array([weight * (name in bench.model.inputs.poses) for name in bench.model.inputs.names])


def _muscles(bench: Bench) -> list[Ask]:
    every = dict.fromkeys(bench.model.inputs.muscles, 1.0)
    return [Ask({}, muscles=every)]
