"""Time from publishing weights to having the mesh, between two processes: benchmarks/ros_latency.py MODEL.

Starts `risorius serve MODEL`, sends weights at 60 Hz and prints median and 99th percentile.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import risorius
from risorius.expressions import expression_loop
from risorius_ros import environment
from risorius_ros.client import FaceClient

RATE_HZ = 60.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("model", type=Path)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--preview", action="store_true", help="serve the page as well")
    arguments = parser.parse_args()
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    os.environ["ROS_DOMAIN_ID"] = str(1 + os.getpid() % 100)
    risorius_command = Path(sys.executable).with_name("risorius")
    options = ["--preview"] if arguments.preview else []
    node = subprocess.Popen([risorius_command, "serve", arguments.model, *options], env=environment.of_child())
    try:
        measure(risorius.load(arguments.model), arguments.seconds)
    finally:
        node.terminate()
        node.wait()


def measure(model: risorius.ReducedModel, seconds: float) -> None:
    loop = expression_loop(model.inputs.names)
    sent: dict[int, int] = {}
    latencies: list[float] = []

    def received(stamp: int, _: object) -> None:
        if stamp in sent:
            latencies.append((time.monotonic_ns() - sent[stamp]) * 1e-6)

    with FaceClient(received) as client:
        client.ask({}, timeout=60.0)
        start = time.monotonic()
        for tick in range(round(seconds * RATE_HZ)):
            before = time.monotonic_ns()
            sent[client.send(loop.weights(tick / RATE_HZ))] = before
            while (rest := start + (tick + 1) / RATE_HZ - time.monotonic()) > 0.0:
                client.spin_once(rest)
    print(
        f"{len(model.rest_vertices)} vertices, {len(model.basis)} coordinates, {RATE_HZ:g} Hz: "
        f"{len(latencies)} of {len(sent)} answered, "
        f"median {np.median(latencies):.2f} ms, p99 {np.percentile(latencies, 99):.2f} ms"
    )


if __name__ == "__main__":
    main()
