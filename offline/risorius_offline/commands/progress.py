"""What a long run tells of itself: a bar, plain lines where no terminal is, or lines of JSON for scripts."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from pathlib import Path

    from rich.console import Console
    from rich.progress import Progress, TaskID

    from risorius_offline.paths import Status

PLAIN_LINES = 20  # of a run, at most


class Display(Protocol):
    """Shows what a run prepares, where it stands, and what came of it."""

    def prepare(self, what: str) -> None:
        """Tell what begins, of what comes before the first snapshot."""
        ...

    def show(self, status: Status) -> None:
        """Show numbers that may have changed."""
        ...

    def finish(self, output: Path, solved: int, failures: list[str]) -> None:
        """Name the file, and list what could not be solved."""
        ...


@dataclass
class Pace:
    """Samples a second since the start of this run, and seconds left at that rate."""

    begun: float = field(default_factory=time.monotonic)
    done_before: int | None = None

    def of(self, status: Status) -> tuple[float, float | None]:
        """Rate and seconds left; 0 and None before the first sample is done."""
        done = status.solved + status.failed
        if self.done_before is None:
            self.done_before = done
        rate = (done - self.done_before) / max(time.monotonic() - self.begun, 1e-9)
        return rate, (status.total - done) / rate if rate else None


@dataclass
class Bar:
    """A progress bar of a terminal, there once there is something to count."""

    console: Console
    progress: Progress
    task: TaskID
    pace: Pace = field(default_factory=Pace)

    def prepare(self, what: str) -> None:
        """Print a line."""
        _print_preparation(self.console, what)

    def show(self, status: Status) -> None:
        """Move the bar."""
        self.progress.start()
        text = _text(status, *self.pace.of(status))
        self.progress.update(self.task, completed=status.solved + status.failed, total=status.total, text=text)

    def finish(self, output: Path, solved: int, failures: list[str]) -> None:
        """Print the end."""
        _print_end(self.console, output, solved, failures)


@dataclass
class Plain:
    """Some twenty lines of a log."""

    console: Console
    pace: Pace = field(default_factory=Pace)
    told: int = -1

    def prepare(self, what: str) -> None:
        """Print a line."""
        _print_preparation(self.console, what)

    def show(self, status: Status) -> None:
        """Print a line now and then."""
        done = status.solved + status.failed
        part = PLAIN_LINES * done // max(status.total, 1)
        text = _text(status, *self.pace.of(status))
        if part != self.told:
            self.told = part
            self.console.print(f"snapshots {done}/{status.total}{', ' if text else ''}{text}", markup=False)

    def finish(self, output: Path, solved: int, failures: list[str]) -> None:
        """Print the end."""
        _print_end(self.console, output, solved, failures)


@dataclass
class JsonLines:
    """An object a line on standard output, whenever something has changed."""

    pace: Pace = field(default_factory=Pace)
    last: Status | None = None

    def prepare(self, what: str) -> None:
        """Write what it is."""
        _write_json(event="preparing", what=what)

    def show(self, status: Status) -> None:
        """Write numbers of samples, rate (1/s), seconds left and error (m)."""
        rate, left = self.pace.of(status)
        if status == self.last:
            return
        self.last = status
        _write_json(
            event="progress",
            solved=status.solved,
            failed=status.failed,
            total=status.total,
            workers=status.workers,
            rate=round(rate, 4),
            seconds_left=None if left is None else round(left, 1),
            error=status.error,
        )

    def finish(self, output: Path, solved: int, failures: list[str]) -> None:
        """Write the end."""
        _write_json(event="finished", output=str(output), solved=solved, failures=failures)


@contextmanager
def display(json_lines: bool) -> Iterator[Display]:
    """Choose what fits: lines of JSON where asked for, else a bar on a terminal, else plain lines on stderr."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    if json_lines:
        yield JsonLines()
        return
    console = Console(stderr=True, soft_wrap=True, highlight=False)
    if not console.is_terminal:
        yield Plain(console)
        return
    columns = ("snapshots", BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[text]}", markup=False))
    progress = Progress(*columns, console=console)
    try:
        yield Bar(console, progress, progress.add_task("snapshots", total=None, text=""))
    finally:
        progress.stop()


def _text(status: Status, rate: float, left: float | None) -> str:
    parts = []
    if rate:
        parts.append(f"{rate:.2f}/s")
    if left:
        parts.append(f"{_clock(left)} left")
    if status.failed:
        parts.append(f"{status.failed} failed")
    if status.error is not None:
        parts.append(f"held-out error 95 % {1e3 * status.error:.3f} mm")
    if not status.workers:
        parts.append("waiting for workers")
    return ", ".join(parts)


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02d}:{rest:02d}"


def _print_preparation(console: Console, what: str) -> None:
    console.print(f"preparing {what}", markup=False)


def _print_end(console: Console, output: Path, solved: int, failures: list[str]) -> None:
    for failure in failures:
        console.print(f"not solved: {failure}", markup=False)
    console.print(f"{output}: {solved} snapshots, {len(failures)} not solved", markup=False)


def _write_json(**entries: object) -> None:
    sys.stdout.write(json.dumps(entries) + "\n")
    sys.stdout.flush()
