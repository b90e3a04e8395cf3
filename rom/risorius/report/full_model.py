"""What one solve of the full model costs: solved in the same run where that can be done, else as stored."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from risorius.errors import MissingExtraError
from risorius.jaw import FloatArray
from risorius.snapshot_file import SnapshotSet, solve_seconds

ENTRY_POINT = "risorius.full_model"
SOLVES = 2  # of each held-out set


class FullModelRun(Protocol):
    """A full model that is timed; the entry point makes one of a source of the anatomy and snapshots' provenance."""

    def solve_seconds(self, parameters: FloatArray) -> FloatArray:
        """Seconds by the clock (k,) of solves from rest to parameters (k, p)."""
        ...

    def way_from(self, guess: FloatArray, parameters: FloatArray) -> list[tuple[float, FloatArray]]:
        """Seconds so far and displacements (n, 3) from a guess to parameters (p,): way[k] took k tangents."""
        ...


@dataclass(frozen=True)
class FullModelTime:
    """Seconds of one solve, median, and where they come from, in words."""

    seconds: float
    origin: str


def stored_time(path: Path, snapshots: SnapshotSet, kind: str) -> FullModelTime:
    """Time of the held-out snapshots of a kind, as the solver reported it when they were made."""
    rows = snapshots.held_out & (np.array(snapshots.kinds) == kind)
    seconds = float(np.median(solve_seconds(path)[rows]))
    return FullModelTime(seconds, f"not measured in this run: CPU seconds stored with {rows.sum()} snapshots")


def measured_time(run: FullModelRun, parameters: FloatArray) -> FullModelTime:
    """Time of a few solves from rest, now."""
    seconds = run.solve_seconds(parameters[:SOLVES])
    return FullModelTime(float(np.median(seconds)), f"measured in this run: {len(seconds)} solves from rest")


def full_model_of(source: str, provenance: Mapping[str, Any]) -> FullModelRun:
    """The full model of the snapshots of a provenance. Raises MissingExtraError without the offline part."""
    found = tuple(entry_points(group=ENTRY_POINT))
    if not found:
        raise MissingExtraError("solving the full model", "offline", "risorius_offline")
    made: FullModelRun = found[0].load()(source, provenance)
    return made
