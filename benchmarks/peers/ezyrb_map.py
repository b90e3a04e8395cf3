"""EZyRB: POD and radial basis functions, as in its tutorials; the kernel is the best of those without a scale."""

from __future__ import annotations

import ezyrb
import numpy as np

from peers.snapshot_fields import SnapshotFields, best_setting, cpu_seconds
from risorius.report.candidates import Candidate, Family, OfflineCost

FAMILY = Family("EZyRB", 1, "#009E73", "D")
KERNELS = ("thin_plate_spline", "cubic", "linear")


def candidate(fields: SnapshotFields, solves: float) -> Candidate:
    def train() -> tuple[str, ezyrb.ReducedOrderModel]:
        kernel = best_setting(fields, KERNELS, lambda part, kernel: _answer(_fitted(part, kernel)))
        return kernel, _fitted(fields, kernel)

    (kernel, rom), seconds = cpu_seconds(train)
    return Candidate(
        name=f"EZyRB POD+RBF ({kernel.replace('_', ' ')})",
        method="EZyRB POD+RBF",
        family=FAMILY,
        coordinates=lambda parameters: rom.approximation.predict(parameters[None])[0],
        vertices=lambda parameters: fields.seen(rom.predict(parameters)[0]),
        offline=OfflineCost(len(fields.parameters), solves, seconds),
    )


def _fitted(fields: SnapshotFields, kernel: str) -> ezyrb.ReducedOrderModel:
    database = ezyrb.Database(fields.parameters, fields.displacements)
    return ezyrb.ReducedOrderModel(database, ezyrb.POD("svd", rank=fields.rank), ezyrb.RBF(kernel)).fit()


def _answer(rom: ezyrb.ReducedOrderModel):
    def answer(parameters: np.ndarray) -> np.ndarray:
        return np.asarray(rom.predict(parameters)[0])

    return answer
