"""The node in a process of its own, for tests that talk to it."""

from __future__ import annotations

import itertools
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from risorius_ros import environment
from risorius_ros.client import FaceClient

RISORIUS = Path(sys.executable).with_name("risorius")
PATIENCE_S = 60.0
_numbers = itertools.count()


class ServedNode:
    """`risorius serve` as a process, in a namespace of its own; its messages go to a file."""

    def __init__(self, model: Path, options: tuple[str, ...], log: Path) -> None:
        self.name = f"/test_{os.getpid()}_{next(_numbers)}/face_engine"
        self._log = log
        command = [RISORIUS, "serve", model, *options, "--ros-args", "-r", f"__ns:={Path(self.name).parent}"]
        with log.open("w") as file:
            self.process = subprocess.Popen(command, env=environment.of_child(), stdout=file, stderr=subprocess.STDOUT)

    @property
    def output(self) -> str:
        return self._log.read_text()

    def stopped_by(self, number: signal.Signals) -> int:
        self.process.send_signal(number)
        return self.process.wait(PATIENCE_S)


@contextmanager
def served(model: Path, *options: str, log: Path) -> Iterator[ServedNode]:
    node = ServedNode(model, options, log)
    try:
        yield node
    finally:
        node.process.terminate()
        node.process.wait(PATIENCE_S)


def spin_until(client: FaceClient, reached: Callable[[], object]) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not reached():
        assert time.monotonic() < deadline, "nothing arrived in time"
        client.spin_once(0.05)
