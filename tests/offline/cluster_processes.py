"""A Dask scheduler and workers as separate processes on loopback, and runs of snapshots that can be killed."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import numpy as np
import psutil

from risorius.mechanics.material import Yeoh
from risorius.snapshot_store import Samples
from tests.offline.models import muscle_block

ROOT = Path(__file__).parents[2]
RUN = """
import sys
from pathlib import Path
from risorius_offline.cluster import local_cluster, running_cluster
from risorius_offline.snapshots import solve_design
from tests.offline.cluster_processes import block_run, levels
from risorius.errors import Error

def report(status):
    print(status.solved, flush=True)

def main(address, output, count):
    try:
        with running_cluster(address) if address else local_cluster(2) as client:
            solve_design(block_run(Path(output)), levels(int(count)), client, report)
    except Error as error:
        sys.exit(f"error: {error}")
    except KeyboardInterrupt:
        sys.exit(130)

if __name__ == "__main__":
    main(*sys.argv[1:])
"""


def block_run(output: Path):
    """A block with some tenth of a second a sample."""
    from risorius_offline.snapshots import FullModelChoice, Run

    return Run(FullModelChoice(muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3), cells=(6, 6, 6))), output)


def levels(count: int) -> Samples:
    """Samples of one muscle at falling activations; the last is held out."""
    number = np.arange(count)
    return Samples(np.linspace(1.0, 0.1, count)[:, None], ["level"] * count, number == count - 1, number // 4)


def python(*arguments: object, pipe: int) -> subprocess.Popen[str]:
    """A Python process that finds this project, and leads a session of its own, as one of a terminal does."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([*sys.path, str(ROOT)])}
    command = [sys.executable, *map(str, arguments)]
    return subprocess.Popen(command, env=environment, start_new_session=True, stdout=pipe, stderr=pipe, text=True)


@contextmanager
def started_run(folder: Path, address: str, output: Path, count: int) -> Iterator[subprocess.Popen[str]]:
    """A run of `count` samples on the cluster at an address, or with two workers of its own."""
    script = folder / "run.py"
    script.write_text(RUN)
    with ended(python(script, address, output, count, pipe=subprocess.PIPE)) as run:
        yield run


def wait_until_solved(run: subprocess.Popen[str], count: int) -> None:
    """Return as soon as a run says that so many samples are solved."""
    assert run.stdout is not None
    for line in run.stdout:
        if int(line) >= count:
            return
    raise AssertionError(f"the run ended early: {run.communicate()[1]}")


@contextmanager
def ended(process: subprocess.Popen[str]) -> Iterator[subprocess.Popen[str]]:
    """Kill a process at last."""
    with process:
        try:
            yield process
        finally:
            process.kill()


@contextmanager
def cluster_processes(workers: int) -> Iterator[tuple[str, subprocess.Popen[str], list[subprocess.Popen[str]]]]:
    """Address of the scheduler, its process and those of workers of one thread each."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    local = ("--host", "127.0.0.1", "--no-dashboard", "--dashboard-address", "127.0.0.1:0")
    scheduler = ("-m", "distributed.cli.dask_scheduler", *local, "--port", address.rpartition(":")[2])
    worker = ("-m", "distributed.cli.dask_worker", address, *local, "--nthreads", 1, "--no-nanny")
    with ExitStack() as stack:
        first, *others = (
            stack.enter_context(ended(python(*arguments, pipe=subprocess.DEVNULL)))
            for arguments in (scheduler, *[worker] * workers)
        )
        yield address, first, others


def others_of_session(run: subprocess.Popen[str]) -> list[int]:
    """Processes of the session of a run, except itself."""
    found = []
    for pid in psutil.pids():
        with suppress(ProcessLookupError):
            if os.getsid(pid) == run.pid and pid != run.pid:
                found.append(pid)
    return found
