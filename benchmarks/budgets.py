"""Whether budgets hold: benchmarks/budgets.py MODEL [--frames 10000].

For each time asked for an engine is made, which times its operating points on this machine and takes one; random frames
are then timed, half of them of about one to seven random inputs, half of all inputs at random. Prints the share of
frames that took longer, and of the least of three runs of each frame, which leaves out what else the machine did.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"

# isort: split

import argparse
import logging
import time
from pathlib import Path

import numpy as np

import risorius

RUNS = 3
WARM_UP = 200
MICROSECONDS = (100, 150, 200, 300, 500, 1000, 2000)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model", type=Path)
    parser.add_argument("--frames", type=int, default=10_000)
    options = parser.parse_args()
    logging.basicConfig(format="%(message)s")
    model = risorius.load(options.model)
    present = {"contact", "gravity", "inertia", "touch"} & set(model.effects)
    scenes = {"all effects": risorius.Scene(), "no effects": risorius.Scene(**dict.fromkeys(sorted(present), False))}
    for name, scene in scenes.items() if present else [("no effects", risorius.Scene())]:
        for microseconds in MICROSECONDS:
            engine = risorius.Engine(model, scene, risorius.Budget(time=1e-6 * microseconds))
            print(f"{name}, {microseconds} us: {engine.point.setting}: {told(engine, options.frames, microseconds)}")


def told(engine: risorius.Engine, count: int, microseconds: float) -> str:
    weights = random_weights(engine, count)
    for row in weights[:WARM_UP]:
        engine.evaluate(row)
    seconds = 1e6 * np.array([[timed(engine, row) for _ in range(RUNS)] for row in weights])
    first, least = seconds[:, 0], seconds.min(axis=1)
    return (
        f"median {np.median(first):.0f}, 99 % {np.quantile(first, 0.99):.0f} us; over: "
        f"{100 * (first > microseconds).mean():.2f} % of frames, {100 * (least > microseconds).mean():.2f} % at best"
    )


def random_weights(engine: risorius.Engine, count: int) -> np.ndarray:
    """Weights (count, inputs): of every second row a tenth of the inputs is at work, of the others all."""
    rng, size = np.random.default_rng(1), len(engine.inputs)
    weights = rng.uniform(0.0, 1.0, (count, size))
    weights[::2] *= rng.random((len(weights[::2]), size)) < 4.0 / size
    return weights


def timed(engine: risorius.Engine, weights: np.ndarray) -> float:
    begin = time.perf_counter()
    engine.evaluate(weights)
    return time.perf_counter() - begin


if __name__ == "__main__":
    main()
