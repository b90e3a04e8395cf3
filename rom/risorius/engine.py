"""The online engine: named weights in, a deformed face out."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from risorius.errors import InputError
from risorius.evaluators import LEARNED, Superposition
from risorius.inputs import Weight
from risorius.jaw import FloatArray
from risorius.model import ReducedModel
from risorius.reconstruction import reconstruction
from risorius.scene import Scene

Weights = Mapping[str, Weight] | npt.ArrayLike


@dataclass(frozen=True)
class Frame:
    """One evaluated face.

    vertices: (n, 3) float32, metres. coordinates: (r,) reduced coordinates. error: metres, estimated upper bound of
    the vertex error against the full model, calibrated to hold on 95 % of held-out snapshots. method: the evaluator
    that answered. converged: False when the evaluator could not answer; the frame is then the last good state.
    elapsed: seconds.
    """

    vertices: npt.NDArray[np.float32]
    coordinates: FloatArray
    error: float
    method: str
    converged: bool
    elapsed: float


class Engine:
    """Evaluates a reduced model for one scene. Not thread-safe: one engine per thread.

    Raises InputError when the model has no evaluator for the scene.
    """

    def __init__(self, model: ReducedModel, scene: Scene | None = None) -> None:
        self.model = model
        self.scene = scene or Scene()
        learned = next((name for name in LEARNED if name in model.evaluators), LEARNED[0])
        wanted = learned if self.scene.nonlinear else Superposition.name
        if wanted not in model.evaluators:
            raise InputError(f"model {model.name!r} has no evaluator {wanted!r}, which the scene needs; train it anew")
        self._evaluator = model.evaluators[wanted]
        self._linear = model.evaluators[Superposition.name] if self.scene.nonlinear else None
        self._accuracy = model.accuracy[wanted]
        self._reconstruction = reconstruction(model.carried_basis, model.rest_vertices)
        self._coordinates = np.zeros(model.rank)
        self._muscle_count = len(model.inputs.muscles)
        self._linear_part = np.zeros(model.rank - model.lifts)
        self.evaluate(np.zeros(len(self.inputs)))  # compiles the kernels, so that the first frame is not late

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs, in the order of a weight array."""
        return self.model.inputs.names

    @property
    def triangles(self) -> npt.NDArray[np.int32]:
        """(m, 3) vertex numbers, counter-clockwise seen from outside."""
        return self.model.triangles

    def evaluate(
        self,
        weights: Weights | None = None,
        *,
        muscles: Mapping[str, Weight] | None = None,
        out: npt.NDArray[np.float32] | None = None,
    ) -> Frame:
        """Evaluate input weights (a mapping by name, or an array in `inputs` order) and/or muscle activations.

        Named weights are numbers or FACS letters A to E. Muscle activations add to what the inputs ask of the same
        muscle, up to full activation. `out`, an (n, 3) float32 array, receives the vertices without another copy.
        Raises InputError for an unknown name or a weight out of range.
        """
        start = time.perf_counter()
        parameters = self._parameters(weights, muscles)
        q = self._coordinates
        modal = q[self.model.lifts :]
        self.model.poses.lift_coordinates(parameters[self._muscle_count :], out=q[: self.model.lifts])
        self._evaluator.coordinates(parameters, modal)
        if self._linear:
            self._linear.coordinates(parameters, self._linear_part)
        interaction = float(np.linalg.norm(modal - self._linear_part))
        vertices = self._reconstruct(q, out)
        return Frame(
            vertices=vertices,
            coordinates=q.copy(),
            error=self._accuracy.error_floor + self._accuracy.error_slope * interaction,
            method=self._evaluator.name,
            converged=True,
            elapsed=time.perf_counter() - start,
        )

    def _parameters(self, weights: Weights | None, muscles: Mapping[str, Weight] | None) -> FloatArray:
        table = self.model.inputs
        if weights is None or isinstance(weights, Mapping):
            return table.to_parameters(table.weights(weights or {}), muscles)
        return table.to_parameters(table.checked(weights), muscles)

    def _reconstruct(self, q: FloatArray, out: npt.NDArray[np.float32] | None) -> npt.NDArray[np.float32]:
        shape = self.model.rest_vertices.shape
        vertices = np.empty(shape, dtype=np.float32) if out is None else out
        if vertices.shape != shape or vertices.dtype != np.float32 or not vertices.flags.c_contiguous:
            raise InputError(
                f"out: give a contiguous float32 array of shape {shape}, not {vertices.dtype} {vertices.shape}"
            )
        self._reconstruction.write(q, vertices)
        return vertices
