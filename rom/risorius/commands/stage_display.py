"""Stages of a training as a person sees them: a bar for each on a terminal, else a line for each."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import timedelta
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress, TaskID

    from risorius.training_stages import Stages

PLAIN_PARTS = 4  # lines of a stage whose share is known


@dataclass
class Bars:
    """A bar for each stage, with the time that it has taken; it ends in its full length."""

    progress: Progress
    task: TaskID | None = None

    def begin(self, name: str) -> None:
        """End the bar before, and begin one that moves to and fro."""
        self.end()
        self.task = self.progress.add_task(name, total=None)

    def reached(self, share: float) -> None:
        """Move the bar."""
        if self.task is not None:
            self.progress.update(self.task, total=1.0, completed=share)

    def end(self) -> None:
        """End the last bar."""
        if self.task is not None:
            self.progress.update(self.task, total=1.0, completed=1.0)


@dataclass
class Lines:
    """Lines of a log: the time since the start, and what is at work."""

    console: Console
    begun: float = field(default_factory=time.monotonic)
    name: str = ""
    told: int = 0

    def begin(self, name: str) -> None:
        """Print a line."""
        self.name, self.told = name, 0
        self._print(name)

    def reached(self, share: float) -> None:
        """Print a line for each quarter between beginning and end."""
        part = int(PLAIN_PARTS * share)
        if self.told < part < PLAIN_PARTS:
            self.told = part
            self._print(f"{self.name}, {100 * part // PLAIN_PARTS} %")

    def _print(self, text: str) -> None:
        elapsed = timedelta(seconds=round(time.monotonic() - self.begun))
        self.console.print(f"training {elapsed} {text}", markup=False)


@contextmanager
def stage_display() -> Iterator[Stages]:
    """Choose what fits standard error."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True, soft_wrap=True, highlight=False)
    if not console.is_terminal:
        yield Lines(console)
        return
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console) as progress:
        bars = Bars(progress)
        yield bars
        bars.end()
