"""What acts from outside: time steps of any length, gravity, touches, teeth and lips."""

from __future__ import annotations

from functools import partial

import numpy as np

from risorius.effects import Touch
from risorius.gauntlet.case import Ask, Bench, Case, NotApplicableError, asks

STEPS = (1e-4, 1e-3, 4e-3, 1.0 / 60.0, 1.0 / 30.0, 0.1)
SECONDS, MOST_FRAMES = 1.0, 200
STANDARD_GRAVITY = 9.81
DIRECTIONS = {"upright": (0, -1, 0), "upside down": (0, 1, 0), "on the back": (0, 0, -1), "face down": (0, 0, 1),
              "on the left": (1, 0, 0), "on the right": (-1, 0, 0)}  # fmt: skip
TOUCHES = (1e-3, 0.1, 1.0)  # newtons
PRESSED = ({"AU18": 1.0}, {"AU22": 1.0}, {"AU23": 1.0}, {"AU24": 1.0}, {"AU28": 1.0}, {"AU8": 1.0},
           {"AU18": 1.0, "AU24": 1.0}, {"AU17": 1.0, "AU24": 1.0}, {"AU18": 1.0, "jaw_open": 0.3})  # fmt: skip


def acting_cases() -> list[Case]:
    """Cases of effects; not applicable where a model lacks them."""
    cases = []
    for step in STEPS:
        shown = f"steps of {1e3 * step:.3g} ms"
        cases += [
            Case(f"{shown}: square wave of every input", "inertia", partial(_square, step)),
            Case(f"{shown}: poses jump to 1, then left alone", "inertia", partial(_let_go, step)),
            Case(f"{shown}: random frames", "inertia", partial(_random, step)),
        ]
    cases.append(Case("steps of 0.1 to 100 ms in random order", "inertia", _mixed))
    for name, direction in DIRECTIONS.items():
        cases.append(Case(f"head {name}", "gravity", partial(_turned, direction)))
    cases.append(Case("head spins between frames", "gravity", _spinning))
    cases += [Case(f"touched with {force:g} N", "touch", partial(_touched, force)) for force in TOUCHES]
    for named in PRESSED:
        name = " + ".join(f"{unit} = {weight:g}" for unit, weight in named.items())
        cases.append(Case(f"contact under {name}", "contact", partial(_pressed, named)))
    return cases


def _count(step: float) -> int:
    return min(int(SECONDS / step), MOST_FRAMES)


def _square(step: float, bench: Bench) -> list[Ask]:
    bench.require_effect("inertia")
    every = np.ones_like(bench.lower)
    return [Ask(every * (number % 2), step=step) for number in range(_count(step))]


def _let_go(step: float, bench: Bench) -> list[Ask]:
    bench.require_effect("inertia")
    if not bench.model.inputs.poses:
        raise NotApplicableError("no poses")
    posed = bench.weights(dict.fromkeys(bench.model.inputs.poses, 1.0))  # bones do not lag: one frame, and all is free
    return [Ask(0.0 * posed), *(Ask(posed, step=step, free=number > 0) for number in range(_count(step)))]


def _random(step: float, bench: Bench) -> list[Ask]:
    bench.require_effect("inertia")
    return [Ask(row, step=step) for row in bench.random(4, 0.3, _count(step))]


def _mixed(bench: Bench) -> list[Ask]:
    bench.require_effect("inertia")
    steps = np.random.default_rng(0).choice(STEPS, MOST_FRAMES)
    return [Ask(row, step=float(step)) for row, step in zip(bench.random(5, 0.3, len(steps)), steps, strict=True)]


def _turned(direction: tuple[float, ...], bench: Bench) -> list[Ask]:
    bench.require_effect("gravity")
    gravity = STANDARD_GRAVITY * np.array(direction, np.float64)
    return [Ask(row, gravity=gravity) for row in bench.random(6, 0.1, 10)]


def _spinning(bench: Bench) -> list[Ask]:
    bench.require_effect("gravity")
    directions = np.random.default_rng(7).normal(size=(60, 3))
    directions *= STANDARD_GRAVITY / np.linalg.norm(directions, axis=1, keepdims=True)
    return [Ask(row, gravity=one) for row, one in zip(bench.random(7, 0.1, 60), directions, strict=True)]


def _touched(force: float, bench: Bench) -> list[Ask]:
    bench.require_effect("touch")
    rng = np.random.default_rng(8)
    vertices = rng.integers(0, len(bench.model.rest_vertices), 20)
    pushes = rng.normal(size=(20, 3))
    pushes *= force / np.linalg.norm(pushes, axis=1, keepdims=True)
    touches = [(Touch(int(vertex), push),) for vertex, push in zip(vertices, pushes, strict=True)]
    return [Ask(row, touches=one, may_refuse=True) for row, one in zip(bench.random(8, 0.1, 20), touches, strict=True)]


def _pressed(named: dict[str, float], bench: Bench) -> list[Ask]:
    bench.require_effect("contact")
    weights = bench.weights(named)
    return asks(level * weights for level in np.linspace(0.0, 1.0, 11))
