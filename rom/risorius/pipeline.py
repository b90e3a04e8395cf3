"""One frame at one setting: parameters to coordinates, coordinates to vertices."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from risorius.error_bound import indicate
from risorius.evaluators import Setting, Superposition
from risorius.jaw import FloatArray
from risorius.model import ReducedModel
from risorius.reconstruction import Reconstruction, reconstruction


class Pipeline:
    """Evaluates a model as a setting has it, without allocating anything. Not thread-safe: it owns its buffers.

    coordinates: (r,) of the model, zero for modes that the setting does without.
    """

    def __init__(self, model: ReducedModel, setting: Setting, surface: Reconstruction) -> None:
        self.coordinates = np.zeros(model.rank)
        self._poses, self._muscles = model.poses, len(model.inputs.muscles)
        self._used = self.coordinates[: model.lifts + setting.rank]
        self._lifts, self._modal = self._used[: model.lifts], self._used[model.lifts :]
        self._evaluator = model.evaluators[setting.method].at(setting)
        linear = setting.method == Superposition.name
        self._linear = None if linear else model.evaluators[Superposition.name].at(setting)
        self._linear_part = self._modal if linear else np.zeros(setting.rank)
        self._surface = surface

    def solve(self, parameters: FloatArray) -> tuple[float, ...]:
        """Set the coordinates of parameters (p,). Returns the indicators of the error bound."""
        self._poses.lift_coordinates(parameters[self._muscles :], out=self._lifts)
        self._evaluator.coordinates(parameters, self._modal)
        if self._linear is not None:
            self._linear.coordinates(parameters, self._linear_part)
        return (*indicate(parameters, self._modal, self._linear_part), self._evaluator.doubt)

    def write(self, out: npt.NDArray[np.float32]) -> None:
        """Write the vertices (n, 3) into contiguous `out`."""
        self._surface.write(self._used, out)


def pipelines(model: ReducedModel, settings: Iterable[Setting]) -> list[Pipeline]:
    """One for each setting; those of the same rank share what writes the vertices."""
    surfaces: dict[int, Reconstruction] = {}
    built = []
    for setting in settings:
        if setting.rank not in surfaces:
            basis = model.carried_basis.leading(model.lifts + setting.rank)
            surfaces[setting.rank] = reconstruction(basis, model.rest_vertices)
        built.append(Pipeline(model, setting, surfaces[setting.rank]))
    return built
