"""The machine and how busy it was: without it a time means nothing."""

from __future__ import annotations

import os
import platform
import time
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

THREADS = "OPENBLAS_NUM_THREADS"
PACKAGES = ("risorius", "numpy", "scipy", "numba", "ezyrb", "torch", "pymor")


@dataclass(frozen=True)
class Machine:
    """load_before, load_after: mean number of running processes over the last minute. date: UTC.

    threads: what the environment allows to BLAS; our own kernels have one.
    """

    processor: str
    cores: int
    threads: str
    load_before: float
    load_after: float
    date: str
    versions: dict[str, str]

    @property
    def busy(self) -> bool:
        """Whether others wanted the cores too: then the slowest frames are those that had to wait."""
        return max(self.load_before, self.load_after) > 0.5 * self.cores + 1.0


def machine(load_before: float) -> Machine:
    """This machine, now; load_before: `load()` before the measurement."""
    return Machine(
        processor=_processor(),
        cores=os.cpu_count() or 1,
        threads=os.environ.get(THREADS, "not limited"),
        load_before=load_before,
        load_after=load(),
        date=time.strftime("%Y-%m-%d %H:%M", time.gmtime()),
        versions={"python": platform.python_version(), **_versions()},
    )


def load() -> float:
    """Load average of the last minute."""
    return os.getloadavg()[0]


def _processor() -> str:
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        for line in cpuinfo.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _versions() -> dict[str, str]:
    found = {}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found
