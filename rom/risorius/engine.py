"""The online engine: named weights in, a deformed face out."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from risorius.budget import Budget
from risorius.choosing import taken
from risorius.effects import Surroundings, Touch
from risorius.effects.effect import UPRIGHT, vector
from risorius.effort import Effort
from risorius.errors import InputError
from risorius.guard import Verdict
from risorius.inputs import Weight
from risorius.jaw import FloatArray
from risorius.model import ReducedModel
from risorius.normals import vertex_normals
from risorius.pipeline import ALONE
from risorius.plan import planned
from risorius.scene import Scene
from risorius.strain import SurfaceStrain

Weights = Mapping[str, Weight] | npt.ArrayLike
_METHOD = {Verdict.GOOD: "{}", Verdict.MENDED: "{}, mended", Verdict.HELD: "held"}
# Of a frame, by the effect that they ask for.
_ARGUMENTS = {"inertia": "step", "gravity": "gravity", "touch": "touches"}


@dataclass(frozen=True)
class Frame:
    """One evaluated face.

    vertices: (n, 3) float32, metres. coordinates: (r,) reduced coordinates. error: metres, estimated upper bound of
    the vertex error against the full model, calibrated to hold on 95 % of held-out snapshots; infinite where nothing is
    known. method: the evaluator that answered, followed by ", mended" where tissue would have folded and was changed as
    little as that takes, and by ", went back" where lips or teeth could not be parted and the mouth is nearer to rest
    than was asked for, both of which `error` contains; or "held": nothing could be answered, and the frame is the last
    good state. converged: False for that. elapsed: seconds. Where the scene wants them: normals (n, 3), of unit
    length; strain (m, 2) of the triangles, principal Green-Lagrange in their plane, the larger first; effort
    (muscles,), joules that each gives off.
    """

    vertices: npt.NDArray[np.float32]
    coordinates: FloatArray
    error: float
    method: str
    converged: bool
    elapsed: float
    normals: npt.NDArray[np.float32] | None = None
    strain: npt.NDArray[np.float32] | None = None
    effort: FloatArray | None = None


class Engine:
    """Evaluates a reduced model for one scene. Not thread-safe: one engine per thread.

    point: the operating point that the budget buys on this machine; without one, the most accurate whose frames took a
    millisecond at training. A budget that none meets is not an error: the nearest is taken, and the log warns.
    model: what the scene leaves of the model. vertex_numbers (n,): of its vertices in the whole model. effects: names
    of those that the scene calls for. Raises InputError when the model has not what the scene asks for.
    """

    def __init__(self, model: ReducedModel, scene: Scene | None = None, budget: Budget | None = None) -> None:
        self.scene = scene or Scene()
        plan = planned(model, self.scene)
        self.model, self.vertex_numbers = plan.model, plan.vertex_numbers
        outputs = self.scene.outputs
        self._normals = "normals" in outputs
        self._strain = SurfaceStrain(self.model.rest_vertices, self.triangles) if "strain" in outputs else None
        self._effort = None if plan.muscles is None else Effort(plan.muscles)
        self.point, self._pipeline = taken(self.model, budget or self.scene.budget)
        self.effects = tuple(self.model.effects)
        self._warm_up()

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs, in the order of a weight array."""
        return self.model.inputs.names

    @property
    def triangles(self) -> npt.NDArray[np.int32]:
        """(m, 3) vertex numbers, counter-clockwise seen from outside."""
        return self.model.triangles

    @property
    def energy(self) -> float:
        """Joules of tissue that moves in the last frame; 0 without inertia."""
        return self._pipeline.energy

    def evaluate(
        self,
        weights: Weights | None = None,
        *,
        muscles: Mapping[str, Weight] | None = None,
        step: float | None = None,
        gravity: npt.ArrayLike | None = None,
        touches: Sequence[Touch] = (),
        out: npt.NDArray[np.float32] | None = None,
    ) -> Frame:
        """Evaluate input weights (a mapping by name, or an array in `inputs` order) and/or muscle activations.

        Named weights are numbers or FACS letters A to E. Muscle activations add to what the inputs ask of the same
        muscle, up to full activation. step: seconds since the last frame; without it the face is at rest under its
        loads, whatever was before. gravity: (3,) m/s2 in the frame of the head; upright without it. touches: forces on
        vertices. `out`, an (n, 3) float32 array, receives the vertices without another copy.
        Raises InputError, before anything changes, for an unknown name, a weight out of range, or what the effects of
        the scene do not show.
        """
        start = time.perf_counter()
        parameters = self._parameters(weights, muscles)
        surroundings = self._surroundings(step, gravity, touches)
        vertices = self._buffer(out)
        indicators = self._pipeline.solve(parameters, surroundings)
        self._pipeline.write(vertices)
        verdict = self._pipeline.verdict
        normals = vertex_normals(vertices, self.triangles) if self._normals else None
        strain = None if self._strain is None else self._strain.of(vertices)
        effort = None
        if self._effort is not None:
            activations = self._pipeline.parameters[: len(self.model.inputs.muscles)]
            effort = self._effort.of(activations, self._pipeline.coordinates[: self.model.rank])
        return Frame(
            vertices=vertices,
            coordinates=self._pipeline.coordinates.copy(),
            error=self.point.bound.value(indicators) + self._pipeline.moved + self._pipeline.gave_way,
            method=self._method(),
            converged=verdict is not Verdict.HELD,
            elapsed=time.perf_counter() - start,
            normals=normals,
            strain=strain,
            effort=effort,
        )

    def _warm_up(self) -> None:
        """Do once what a frame may call for: none is to wait until a kernel is compiled, or loaded."""
        acting = {"inertia": 1e-3, "gravity": UPRIGHT, "touch": (Touch(0, np.zeros(3)),)}
        asked: dict[str, Any] = {_ARGUMENTS[one]: value for one, value in acting.items() if one in self.effects}
        for _ in range(2):  # what moves has been somewhere before
            self.evaluate(np.zeros(len(self.inputs)), **asked)
        self.evaluate()

    def _method(self) -> str:
        verdict = self._pipeline.verdict
        went_back = verdict is not Verdict.HELD and self._pipeline.gave_way > 0.0
        return _METHOD[verdict].format(self.point.setting.method) + (", went back" if went_back else "")

    def _parameters(self, weights: Weights | None, muscles: Mapping[str, Weight] | None) -> FloatArray:
        table = self.model.inputs
        if weights is None or isinstance(weights, Mapping):
            return table.to_parameters(table.weights(weights or {}), muscles)
        return table.to_parameters(table.checked(weights), muscles)

    def _surroundings(
        self, step: float | None, gravity: npt.ArrayLike | None, touches: Sequence[Touch]
    ) -> Surroundings:
        given = {"inertia": step is not None, "gravity": gravity is not None, "touch": bool(touches)}
        if not any(given.values()):
            return ALONE
        for effect, asked in given.items():
            if asked and effect not in self.effects:
                raise InputError(
                    f"{_ARGUMENTS[effect]}: the scene of this engine is without {effect}; it has {self.effects}"
                )
        acceleration = None if gravity is None else vector(gravity, "gravity")
        surroundings = Surroundings(step, acceleration, tuple(touches))
        self._pipeline.check(surroundings)
        return surroundings

    def _buffer(self, out: npt.NDArray[np.float32] | None) -> npt.NDArray[np.float32]:
        shape = self.model.rest_vertices.shape
        vertices = np.empty(shape, dtype=np.float32) if out is None else out
        if vertices.shape != shape or vertices.dtype != np.float32 or not vertices.flags.c_contiguous:
            raise InputError(
                f"out: give a contiguous float32 array of shape {shape}, not {vertices.dtype} {vertices.shape}"
            )
        return vertices
