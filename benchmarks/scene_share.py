"""What six of forty action units and the mouth cost of everything: benchmarks/scene_share.py MODEL.

The share of a frame's CPU time that the scene takes of `Scene()`, with effects and outputs on both sides alike or not,
under three readings of the inputs. `same`: one animation on both sides, random weights of four of the six; `own`:
random weights of four of the scene's own action units on either side; `all`: every input of either at random. Medians
of frames in turn: what else the machine does falls on both. Last, what an effect costs that is off: a scene without any
beside a model that has none, and that beside itself. The most accurate map of the model is taken.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"

# isort: split

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

import risorius
from risorius.inputs import without_side

UNITS = ("AU6", "AU12", "AU15", "AU20", "AU25", "AU26")
TURN, WARM_UP = 16, 4  # frames of one scene after each other, of which the first only fill caches
ACTIVE = 4  # units
STEP = 1.0 / 60.0
ANY_TIME = risorius.Budget(time=1.0)
EVERY_OUTPUT = ("vertices", "normals", "strain", "effort")

Draw = Callable[[np.random.Generator, risorius.Engine, risorius.Engine], list[np.ndarray]]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model", type=Path)
    parser.add_argument("--frames", type=int, default=1200)
    options = parser.parse_args()
    model = risorius.load(options.model)
    for name, (whole, part) in scenes(model).items():
        engines = built(model, whole), built(model, part)
        told = [f"{reading} {share(*engines, draw, options.frames)}" for reading, draw in READINGS.items()]
        print(f"{name} ({engines[0].point.setting}): {'; '.join(told)}", flush=True)
    off = built(model, dict.fromkeys(model.effects, False))
    without = [built(replace(model, effects={}), {}) for _ in range(2)]
    print(f"all effects off, of a model without: {share(without[0], off, same, 4 * options.frames)}")
    print(f"a model without, of itself: {share(*without, same, 4 * options.frames)}")


def built(model: risorius.ReducedModel, fields: dict) -> risorius.Engine:
    return risorius.Engine(model, risorius.Scene(**fields), ANY_TIME)


def scenes(model: risorius.ReducedModel) -> dict[str, tuple[dict, dict]]:
    """Fields of the whole scene and of the six, by what is compared."""
    off = dict.fromkeys(model.effects, False)
    still = {name: False for name in off if name != "contact"}
    six = {"inputs": UNITS, "region": "mouth"}
    return {
        "all effects on both sides": ({}, six),
        "all but contact on both sides": ({"contact": False}, {"contact": False, **six}),
        "no effects on either side": (off, {**off, **six}),
        "all effects, the six with contact alone": ({}, {**still, **six}),
        "all effects, the six without": ({}, {**off, **six}),
        "all effects and outputs, the six with all effects": ({"outputs": EVERY_OUTPUT}, six),
        "all effects and outputs, the six without": ({"outputs": EVERY_OUTPUT}, {**off, **six}),
    }


def share(whole: risorius.Engine, part: risorius.Engine, draw: Draw, frames: int) -> str:
    """Medians of a frame of both and their ratio."""
    rng, engines, seconds = np.random.default_rng(0), (whole, part), ([], [])
    for _ in range(frames // (TURN - WARM_UP)):
        drawn = [draw(rng, whole, part) for _ in range(TURN)]
        for side, (engine, times) in enumerate(zip(engines, seconds, strict=True)):
            step = STEP if "inertia" in engine.effects else None
            weighed = "gravity" in engine.effects
            for number, weights in enumerate(drawn):
                gravity = leaning(number) if weighed else None
                begin = time.thread_time()
                engine.evaluate(weights[side], step=step, gravity=gravity)
                taken = time.thread_time() - begin
                if number >= WARM_UP:
                    times.append(taken)
    most, least = (1e6 * float(np.median(times)) for times in seconds)
    return f"{least:.1f} of {most:.1f} us, {100.0 * least / most:.1f} %"


def leaning(number: int) -> np.ndarray:
    """Gravity (3,) of a head that sways."""
    direction = np.array([0.2 * np.sin(number), -0.96, 0.2])
    return 9.81 * direction / np.linalg.norm(direction)


def same(rng: np.random.Generator, whole: risorius.Engine, part: risorius.Engine) -> list[np.ndarray]:
    """The same weights of some of the six."""
    named = dict(zip(rng.choice(UNITS, ACTIVE, replace=False), rng.uniform(0.0, 1.0, ACTIVE), strict=True))
    return [engine.model.inputs.weights(named) for engine in (whole, part)]


def own(rng: np.random.Generator, whole: risorius.Engine, part: risorius.Engine) -> list[np.ndarray]:
    """Weights of some action units of each."""
    drawn = []
    for engine in (whole, part):
        units = sorted({without_side(name) for name in engine.inputs if name.startswith("AU")})
        named = dict(zip(rng.choice(units, ACTIVE, replace=False), rng.uniform(0.0, 1.0, ACTIVE), strict=True))
        drawn.append(engine.model.inputs.weights(named))
    return drawn


def everything(rng: np.random.Generator, whole: risorius.Engine, part: risorius.Engine) -> list[np.ndarray]:
    """Weights of all inputs of each."""
    return [rng.uniform(engine.model.inputs.lower, 1.0) for engine in (whole, part)]


READINGS: dict[str, Draw] = {"same": same, "own": own, "all": everything}

if __name__ == "__main__":
    main()
