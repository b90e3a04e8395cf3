"""One frame at one setting: parameters to coordinates, coordinates to vertices."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from risorius.effects import Effect, Surroundings
from risorius.error_bound import indicate
from risorius.evaluators import Setting, Superposition
from risorius.guard import Guard, Verdict
from risorius.jaw import FloatArray
from risorius.model import ReducedModel
from risorius.reconstruction import Reconstruction, reconstruction
from risorius.sizes import largest_size

ALONE = Surroundings()
FARTHEST = 2.0  # times the largest coordinate of a vertex at rest: no effect takes skin that far


class Pipeline:
    """Evaluates a model as a setting has it, without allocating anything. Not thread-safe: it owns its buffers.

    parameters: (p,) that the face was evaluated at, which effects may have changed from those that were asked for.
    coordinates: (r,) of the model, zero for modes that the setting does without, then those of the effects' own.
    verdict: of the guard, on the last frame. moved: metres, how far at most the guard has put any vertex from where the
    evaluator and the effects would have; infinite where these gave nothing. gave_way: metres that effects which could
    not show what was asked for have taken any vertex from there, once vertices are written.
    """

    def __init__(
        self, model: ReducedModel, setting: Setting, surface: Reconstruction, effects: Sequence[Effect] = ()
    ) -> None:
        own = [len(effect.fields) for effect in effects]
        self.coordinates = np.zeros(model.rank + sum(own))
        self._poses, self._muscles = model.poses, len(model.inputs.muscles)
        self._face = model.lifts + setting.rank
        every = self._face == model.rank
        self._used = self.coordinates if every else np.zeros(self._face + sum(own))
        self._lifts, self._modal = self._used[: model.lifts], self._used[model.lifts : self._face]
        self._evaluator = model.evaluators[setting.method].at(setting)
        linear = setting.method == Superposition.name
        self._linear = None if linear else model.evaluators[Superposition.name].at(setting)
        self._linear_part = self._modal if linear else np.zeros(setting.rank)
        self._middle = setting.middle
        self._surface = surface
        self.parameters = np.zeros(len(model.inputs.parameters))
        self._effects = [effect.at(setting) for effect in effects]
        self._own = np.split(self._used[self._face :], np.cumsum(own)[:-1]) if own else []
        watch = None if model.watch is None else model.watch.leading(self._face)
        self._guard = Guard(watch, model.lifts, len(self._used))
        self._answered = np.zeros(len(self._used))
        self._farthest = FARTHEST * float(np.abs(model.rest_vertices).max())
        self.verdict, self.moved, self.gave_way = Verdict.GOOD, 0.0, 0.0

    def check(self, surroundings: Surroundings) -> None:
        """Raise InputError for what one of the effects cannot show."""
        for effect in self._effects:
            effect.check(surroundings)

    def solve(self, parameters: FloatArray, surroundings: Surroundings = ALONE) -> tuple[float, ...]:
        """Set the coordinates of parameters (p,). Returns the indicators of the error bound."""
        driven = self.parameters
        driven[:] = parameters
        for effect in self._effects:
            surroundings = effect.drive(driven, surroundings)
        self._poses.lift_coordinates(driven[self._muscles :], out=self._lifts)
        self._evaluator.coordinates(driven, self._modal)
        if self._linear is not None:
            self._linear.coordinates(driven, self._linear_part)
        indicators = (*indicate(driven, self._modal, self._linear_part, self._middle), self._evaluator.doubt)
        for effect, own in zip(self._effects, self._own, strict=True):
            effect.respond(driven, self._used[: self._face], own, surroundings)
        self._settle()
        self._tell()
        return indicators

    @property
    def energy(self) -> float:
        """Joules of what moves; 0 without inertia."""
        return sum(effect.energy for effect in self._effects)

    def write(self, out: npt.NDArray[np.float32]) -> None:
        """Write the vertices (n, 3) into contiguous `out`; without the effects' share where that would explode."""
        self._surface.write(self._used, out)
        self.gave_way = 0.0
        for effect in self._effects:
            effect.finish(self._used, out, self._guard.folds)
            self.gave_way += effect.gave_way
        if self._effects and not largest_size(out.reshape(-1)) <= self._farthest:
            self._surface.write(self._used, out)
            self.verdict, self.moved, self.gave_way = Verdict.HELD, math.inf, 0.0
            self._restart()

    def _settle(self) -> None:
        """Let the guard judge the coordinates; what has brought a frame down does not go on into the next."""
        self._answered[:] = self._used
        self.verdict = self._guard.settle(self._used)
        self.moved = 0.0
        if self.verdict is not Verdict.GOOD:
            self._answered -= self._used
            self.moved = self._surface.reach(self._answered)
        if self.verdict is Verdict.HELD:
            self._restart()

    def _restart(self) -> None:
        for effect in self._effects:
            effect.restart()

    def _tell(self) -> None:
        if self._used is self.coordinates:
            return
        own = len(self._used) - self._face
        self.coordinates[: self._face] = self._used[: self._face]
        if own:
            self.coordinates[-own:] = self._used[self._face :]


def pipelines(model: ReducedModel, settings: Iterable[Setting], effects: Sequence[Effect] = ()) -> list[Pipeline]:
    """One for each setting; those of the same rank share what writes the vertices."""
    surfaces: dict[int, Reconstruction] = {}
    built = []
    for setting in settings:
        if setting.rank not in surfaces:
            leading = model.carried_basis.leading(model.lifts + setting.rank)
            basis = leading.followed_by([effect.fields for effect in effects])
            surfaces[setting.rank] = reconstruction(basis, model.rest_vertices)
        built.append(Pipeline(model, setting, surfaces[setting.rank], effects))
    return built
