"""All that was measured, as rows of one operating point on one held-out set each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from risorius.accuracy import Errors
from risorius.report.candidates import Family, OfflineCost
from risorius.report.full_model import FullModelTime
from risorius.report.machine import Machine
from risorius.report.measuring import Times


@dataclass(frozen=True)
class Row:
    """An operating point, by its name, of a method on a held-out set.

    coordinates: time from parameters to coordinates; frame: on to the vertices.
    """

    name: str
    method: str
    family: Family
    held_out: str
    errors: Errors
    coordinates: Times
    frame: Times
    offline: OfflineCost


@dataclass(frozen=True)
class Results:
    """A report before it has a form.

    full: time of the full model for each held-out set where it is known. frames: timed for each row.
    errors_from, times_from, continued_from: in words, where errors and times come from, and those of the full model
    that goes on from a map. peers: whether other codes are among them.
    """

    model: str
    rank: int
    vertices: int
    rows: tuple[Row, ...]
    full: dict[str, FullModelTime]
    frames: int
    errors_from: str
    times_from: str
    continued_from: str
    peers: bool
    machine: Machine

    @property
    def sets(self) -> tuple[str, ...]:
        """Names of the held-out sets, in order."""
        return tuple(dict.fromkeys(row.held_out for row in self.rows))

    @property
    def names(self) -> tuple[str, ...]:
        """Operating points, in order: plot and tables number them."""
        return tuple(dict.fromkeys(row.name for row in self.rows))

    def of(self, held_out: str) -> tuple[Row, ...]:
        """Rows of one held-out set."""
        return tuple(row for row in self.rows if row.held_out == held_out)


def front(points: Sequence[tuple[float, float]]) -> list[bool]:
    """Which points (time, error) are on the Pareto front: nothing is as good in both and better in one."""
    return [not any(t <= time and e <= error and (t < time or e < error) for t, e in points) for time, error in points]
