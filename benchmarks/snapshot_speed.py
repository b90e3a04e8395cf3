"""Snapshots a second with different numbers of workers: benchmarks/snapshot_speed.py SOURCE [--contact lips].

Each number of workers solves the same samples into a new file. Their start is timed apart: a worker imports, loads
kernels and builds its model once. CPU seconds of the solves tell whether workers slow each other down.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np

from risorius_offline.anatomy import load_source
from risorius_offline.cluster import local_cluster
from risorius_offline.contact_choice import ContactChoice
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.sampling import design
from risorius_offline.snapshots import FullModelChoice, Run, solve_design


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("source")
    parser.add_argument("--snapshots", type=int, default=40)
    parser.add_argument("--contact", type=ContactChoice, choices=list(ContactChoice), default=ContactChoice.NONE)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    arguments = parser.parse_args()
    anatomy = load_source(arguments.source)
    plan = design(anatomy.inputs, arguments.snapshots, 4, 0)
    print(f"{anatomy.name}: {len(anatomy.points)} nodes, {len(plan.parameters)} snapshots")
    for workers in arguments.workers:
        with tempfile.TemporaryDirectory() as folder:
            choice = FullModelChoice(anatomy, EffectChoice(contact=arguments.contact))
            measure(Run(choice, Path(folder) / "s.h5"), plan, workers)


def measure(run: Run, plan, workers: int) -> None:
    reports: list[tuple[float, int]] = []
    begun = time.monotonic()
    with local_cluster(workers) as client:
        solve_design(run, plan, client, lambda status: reports.append((time.monotonic(), status.solved)))
    # From when every worker has solved something on.
    start, before = next(entry for entry in reports if entry[1] >= 2 * workers)
    end, solved = reports[-1]
    with h5py.File(run.output) as file:
        cpu = file["samples/report"]["seconds"]
    print(
        f"{workers} workers: {(solved - before) / (end - start):.3f} snapshots/s, whole run {end - begun:.1f} s, "
        f"CPU seconds a snapshot: median {np.median(cpu):.2f}, mean {np.mean(cpu):.2f}"
    )


if __name__ == "__main__":
    main()
