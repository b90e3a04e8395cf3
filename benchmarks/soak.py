"""A million inputs of every kind through one engine, and whether anything wears: benchmarks/soak.py MODEL.

Ordinary, strong, stepped, out-of-range and non-finite values come as a stream brings them; frames have a time step, a
direction of gravity and now and then a touch where the model has these effects. Prints frames that break a verdict of
the gauntlet, growth of memory, and the CPU time of a frame in the last tenth against the first; exits 1 where one of
these is not as it should be.
"""

from __future__ import annotations

import argparse
import gc
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import psutil

import risorius
from risorius.effects import Touch
from risorius.gauntlet.case import Ask, Bench
from risorius.gauntlet.judge import Judge
from risorius.stream import InputGate

STEPS = (1e-4, 1e-3, 1.0 / 60.0, 0.1)
SHARES = (0.05, 0.1, 0.3, 1.0)
WARM_UP = 2000
TOUCHED = 8  # vertices: a new one costs a solve
BLOCK = 20  # inputs of one kind after each other
JUDGED_EVERY = 50  # frames are judged from outside; all of them by their flags
MOST_GROWTH, MOST_DRIFT = 5e6, 0.1  # bytes, of the time of a frame
BAD = (np.nan, np.inf, -np.inf, 1e30, -1e30, 1.0 + 1e-9, 5e-324, -0.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model", type=Path)
    parser.add_argument("--inputs", type=int, default=1_000_000)
    arguments = parser.parse_args()
    bench = Bench(risorius.load(arguments.model))
    judge, gate = Judge(bench), InputGate(bench.model.inputs)
    stream = asks(bench, gate)
    for _ in range(WARM_UP):
        judge.take(next(stream))
    print(f"{bench.model.name}: {bench.engine.point.setting}, effects {', '.join(bench.engine.effects) or 'none'}")
    sys.exit(run(bench, judge, gate, stream, arguments.inputs))


def run(bench: Bench, judge: Judge, gate: InputGate, stream: Iterator[Ask], inputs: int) -> int:
    tenth, medians, methods = inputs // 10, [], Counter[str]()
    seconds = np.full(tenth, np.nan)  # held before memory is looked at: it is the benchmark's own
    before = memory()
    for part in range(10):
        for number in range(tenth):
            ask = next(stream)
            if number % JUDGED_EVERY == 0:
                judge.take(ask)
            begin = time.process_time()
            try:
                method = bench.evaluate(ask).method
            except risorius.InputError:  # a touch that would move tissue too far
                method = "refused"
            seconds[number] = time.process_time() - begin
            methods[method] += 1
        medians.append(float(np.median(seconds)))
        more = (memory() - before) / 1e6
        print(f"{(part + 1) * tenth} frames, median {1e6 * medians[-1]:.1f} us, memory +{more:.2f} MB", flush=True)
    grown = memory() - before
    judge.finish()
    drift = medians[-1] / medians[0] - 1.0
    broken = {name: count for name, count in judge.broken.items() if count}
    print(f"methods: {dict(methods)}; input: {dict(gate.counts)}")
    print(f"verdicts broken in {judge.frames} judged frames: {broken or 'none'}; smallest J {judge.smallest_jacobian}")
    print(f"memory grew by {grown / 1e6:.2f} MB; last tenth against first {100 * drift:+.1f} %")
    return int(bool(broken) or grown > MOST_GROWTH or drift > MOST_DRIFT)


def asks(bench: Bench, gate: InputGate) -> Iterator[Ask]:
    """Never ends; blocks of inputs of one kind, now and then with values that are none."""
    rng, names = np.random.default_rng(0), bench.model.inputs.names
    inertia, gravity, touch = (name in bench.engine.effects for name in ("inertia", "gravity", "touch"))
    while True:
        rows = bench.random(int(rng.integers(1 << 30)), rng.choice(SHARES), BLOCK)
        if rng.random() < 0.3:
            rows[:] = rows[0]  # a step, and what follows it
        bad = rng.random(BLOCK) < 0.2
        rows[bad, rng.integers(0, len(names), bad.sum())] = rng.choice(BAD, bad.sum())
        steps = rng.choice(STEPS, BLOCK).tolist() if inertia else [None] * BLOCK
        touched = (rng.random(BLOCK) < 0.1) & touch
        down = _direction(rng) if gravity else None
        for values, step, pushed in zip(rows.tolist(), steps, touched, strict=True):
            touches = (_touch(bench, rng),) if pushed else ()
            weights = gate.weights(zip(names, values, strict=True))
            yield Ask(weights, step=step, gravity=down, touches=touches, may_refuse=True)


def _direction(rng: np.random.Generator) -> np.ndarray:
    vector = rng.normal(size=3)
    return 9.81 / np.linalg.norm(vector) * vector


def _touch(bench: Bench, rng: np.random.Generator) -> Touch:
    places = np.linspace(0, len(bench.model.rest_vertices) - 1, TOUCHED, dtype=np.int64)
    return Touch(int(rng.choice(places)), rng.normal(0.0, 0.02, 3))


def memory() -> float:
    """Bytes that are the process's own; what it maps of files comes and goes as the system has it."""
    gc.collect()
    held = psutil.Process().memory_info()
    return float(held.rss - held.shared)


if __name__ == "__main__":
    main()
