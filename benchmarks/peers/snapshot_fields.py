"""What every peer of the reduced model learns from: the training snapshots, and the rank that ours has."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import scipy.sparse as sp

from risorius.model import ReducedModel
from risorius.snapshot_file import SnapshotSet

Setting = TypeVar("Setting")


@dataclass(frozen=True)
class SnapshotFields:
    """parameters (t, p); displacements (t, 3 n) of all nodes; weights (v, n) and rest (v, 3) of what is seen."""

    parameters: np.ndarray
    displacements: np.ndarray
    weights: sp.csr_matrix
    rest: np.ndarray
    rank: int

    @classmethod
    def of(cls, snapshots: SnapshotSet, model: ReducedModel) -> SnapshotFields:
        rows = np.flatnonzero(~snapshots.held_out)
        fields = snapshots.displacements[rows].astype(np.float64).reshape(len(rows), -1)
        return cls(snapshots.parameters[rows], fields, snapshots.surface.weights, snapshots.surface.points, model.rank)

    def seen(self, field: np.ndarray) -> np.ndarray:
        """Visible vertices (v, 3) of displacements (3 n,)."""
        return (self.rest + self.weights @ field.reshape(-1, 3)).astype(np.float32)

    def part(self, rows: np.ndarray) -> SnapshotFields:
        return replace(self, parameters=self.parameters[rows], displacements=self.displacements[rows])


def best_setting(
    fields: SnapshotFields,
    settings: Iterable[Setting],
    fit: Callable[[SnapshotFields, Setting], Callable[[np.ndarray], np.ndarray]],
) -> Setting:
    """The setting with the least error on every fifth training snapshot when fitted to the others.

    fit returns a function from parameters (p,) to displacements (3 n,). Held-out snapshots take no part.
    """
    fifth = np.arange(len(fields.parameters)) % 5 == 4
    learned, tried = fields.part(~fifth), fields.part(fifth)

    def error(setting: Setting) -> float:
        answer = fit(learned, setting)
        pairs = zip(tried.parameters, tried.displacements, strict=True)
        return float(sum(np.square(answer(parameters) - truth).sum() for parameters, truth in pairs))

    return min(settings, key=error)


def cpu_seconds(work: Callable[[], Setting]) -> tuple[Setting, float]:
    """Result of some work and the seconds of the processor that it took."""
    begin = time.process_time()
    result = work()
    return result, time.process_time() - begin
