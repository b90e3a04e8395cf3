"""pyMOR: POD and greedy kernel interpolation (VKOGA), its data-driven reductor as it comes.

With all snapshots as possible centres instead of 20, and the best of some length scales.
"""

from __future__ import annotations

import numpy as np
from pymor.algorithms.ml.vkoga import GaussianKernel, VKOGARegressor
from pymor.core.logger import set_log_levels
from pymor.parameters.base import Parameters
from pymor.reductors.data_driven import DataDrivenPODReductor
from pymor.vectorarrays.numpy import NumpyVectorSpace

from peers.snapshot_fields import SnapshotFields, best_setting, cpu_seconds
from risorius.report.candidates import Candidate, Family, OfflineCost

FAMILY = Family("pyMOR", 1, "#56B4E9", "h")
LENGTH_SCALES = (1.0, 2.0, 4.0, 8.0, 16.0)


class PodKernels:
    """The reductor's model, and its basis."""

    def __init__(self, fields: SnapshotFields, length_scale: float) -> None:
        set_log_levels({"pymor": "ERROR"})
        self._names = Parameters({"weights": fields.parameters.shape[1]})
        space = NumpyVectorSpace(fields.displacements.shape[1])
        self._reductor = DataDrivenPODReductor(
            [self._names.parse(row) for row in fields.parameters],
            space.from_numpy(fields.displacements.T),
            regressor=VKOGARegressor(GaussianKernel(length_scale), max_centers=len(fields.parameters)),
            pod_params={"modes": fields.rank},
        )
        self._model = self._reductor.reduce()

    def coordinates(self, parameters: np.ndarray) -> np.ndarray:
        return self._model.solve(self._names.parse(parameters)).to_numpy()[:, 0]

    def displacements(self, parameters: np.ndarray) -> np.ndarray:
        return self._reductor.reconstruct(self._model.solve(self._names.parse(parameters))).to_numpy()[:, 0]


def candidate(fields: SnapshotFields, solves: float) -> Candidate:
    def train() -> tuple[float, PodKernels]:
        scale = best_setting(fields, LENGTH_SCALES, lambda part, scale: PodKernels(part, scale).displacements)
        return scale, PodKernels(fields, scale)

    (scale, pod), seconds = cpu_seconds(train)
    return Candidate(
        name=f"pyMOR POD+VKOGA (length {scale:g})",
        method="pyMOR POD+VKOGA",
        family=FAMILY,
        coordinates=pod.coordinates,
        vertices=lambda parameters: fields.seen(pod.displacements(parameters)),
        offline=OfflineCost(len(fields.parameters), solves, seconds),
    )
