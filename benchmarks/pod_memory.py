"""Peak memory and time of POD on made-up snapshots that do not fit in memory.

    python benchmarks/pod_memory.py --folder /somewhere --snapshots 20000 --nodes 33334

Fields are 200 random modes with amplitudes that fall as 1 / k^1.5, in a snapshot file as runs write it. The POD runs in
a process of its own; its peak memory is what the operating system says. It is compared with the modes put in.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from risorius.poses import Poses
from risorius.snapshot_file import Face, SnapshotSet
from risorius.snapshot_store import Samples, Solved, create, opened
from risorius.surface import CarriedSurface
from risorius.training import project

MODES, RANK, BATCH = 200, 80, 256


def made_up_face(nodes: int) -> Face:
    points = np.random.default_rng(0).uniform(-0.1, 0.1, (nodes, 3))
    skin = np.arange(nodes - nodes % 3).reshape(-1, 3)
    surface = CarriedSurface.of_nodes(points, skin)
    return Face(
        "made up", ("pull",), Poses(), points, surface, {}, np.full(nodes, 1e-8), np.zeros((0, nodes, 3)), None, None
    )


def write(path: Path, count: int, nodes: int) -> None:
    rng = np.random.default_rng(1)
    modes = np.linalg.qr(rng.normal(size=(3 * nodes, MODES)))[0].T.astype(np.float32)
    amplitudes = (1e-2 * np.sqrt(nodes) / (1.0 + np.arange(MODES)) ** 1.5).astype(np.float32)
    create(path, made_up_face(nodes), {}, {}, derivatives=False)
    with opened(path) as store:
        number, parameters = np.arange(count), rng.uniform(size=(count, 1))
        parameters[0] = 1.0  # the single action, which a POD asks for
        store.add(Samples(parameters, ["ordinary"] * count, number == count - 1, number // 4))
        for first in range(0, count, BATCH):
            last = min(first + BATCH, count)
            fields = (rng.normal(size=(last - first, MODES)).astype(np.float32) * amplitudes) @ modes
            for row in range(first, last):
                store.record(row, Solved.of(fields[row - first].reshape(nodes, 3), {}, {"smallest_jacobian": 1.0}))


def measure(path: Path) -> dict[str, float]:
    before = resource.getrusage(resource.RUSAGE_SELF)
    begun = time.monotonic()
    snapshots = SnapshotSet.load(path)
    modal = project(snapshots, RANK)
    after = resource.getrusage(resource.RUSAGE_SELF)
    return {
        "snapshots": len(snapshots.parameters),
        "components": 3 * len(snapshots.points),
        "modes": len(modal.modes),
        "wall_seconds": time.monotonic() - begun,
        "cpu_seconds": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
        "peak_gigabytes": after.ru_maxrss * 1024 / 1e9,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, required=True, help="where 8 GB find room")
    parser.add_argument("--snapshots", type=int, default=20000)
    parser.add_argument("--nodes", type=int, default=33334)
    parser.add_argument("--measure", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.measure:
        print(json.dumps(measure(arguments.measure)))
        return
    path = arguments.folder / "made_up.h5"
    begun = time.monotonic()
    write(path, arguments.snapshots, arguments.nodes)
    print(f"{path}: {path.stat().st_size / 1e9:.2f} GB, written in {time.monotonic() - begun:.0f} s", flush=True)
    subprocess.run([sys.executable, __file__, "--folder", arguments.folder, "--measure", path], check=True)
    path.unlink()


if __name__ == "__main__":
    main()
