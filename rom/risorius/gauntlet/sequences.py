"""Inputs that change faster than any face."""

from __future__ import annotations

from functools import partial

import numpy as np

from risorius.gauntlet.case import Ask, Bench, Case, asks

FRAMES = 120
SHARES = {"few inputs": 0.1, "half of the inputs": 0.5, "all inputs": 1.0}


def sequence_cases() -> list[Case]:
    """Square waves, walks and jumps; without time, as a static engine is asked."""
    cases = [
        Case("square wave of 60 Hz, every input", "sequences", lambda bench: _square(bench, np.ones_like(bench.lower))),
        Case("square wave of 60 Hz, lowest against highest", "sequences", _lowest_against_highest),
        Case("square wave of 60 Hz, AU12", "sequences", lambda bench: _square(bench, bench.weights({"AU12": 1.0}))),
        Case("square wave of 60 Hz, jaw", "sequences", lambda bench: _square(bench, bench.weights({"jaw_open": 1.0}))),
        Case("one-frame jump from rest to everything and back", "sequences", _jump),
        Case("ramp to everything in 120 frames", "sequences", _ramp),
        Case("every input in turn, from one frame to the next", "sequences", _in_turn),
    ]
    for seed, (name, share) in enumerate(SHARES.items()):
        cases.append(Case(f"random walk, {name}", "sequences", partial(_walk, seed, share)))
        cases.append(Case(f"independent random frames, {name}", "sequences", partial(_random, seed, share)))
        cases.append(Case(f"random corners, {name}", "sequences", partial(_corners, seed, share)))
    return cases


def _square(bench: Bench, weights: np.ndarray) -> list[Ask]:
    return asks(weights * (number % 2) for number in range(FRAMES))


def _lowest_against_highest(bench: Bench) -> list[Ask]:
    return asks(bench.lower if number % 2 else np.ones_like(bench.lower) for number in range(FRAMES))


def _jump(bench: Bench) -> list[Ask]:
    none, every = np.zeros_like(bench.lower), np.ones_like(bench.lower)
    return asks([none, none, every, none, none, every, every, none])


def _ramp(bench: Bench) -> list[Ask]:
    return asks(level * np.ones_like(bench.lower) for level in np.linspace(0.0, 1.0, FRAMES))


def _in_turn(bench: Bench) -> list[Ask]:
    return asks(np.eye(len(bench.lower)))


def _walk(seed: int, share: float, bench: Bench) -> list[Ask]:
    rng, active = np.random.default_rng(seed), bench.random(seed, share, 1)[0] != 0.0
    weights, rows = np.zeros_like(bench.lower), []
    for _ in range(FRAMES):
        weights = np.clip(weights + active * rng.normal(0.0, 0.2, len(weights)), bench.lower, 1.0)
        rows.append(weights)
    return asks(rows)


def _random(seed: int, share: float, bench: Bench) -> list[Ask]:
    return asks(bench.random(seed, share, FRAMES))


def _corners(seed: int, share: float, bench: Bench) -> list[Ask]:
    rows = bench.random(seed, share, FRAMES)
    return asks(np.where(rows > 0.0, 1.0, np.where(rows < 0.0, bench.lower, 0.0)))
