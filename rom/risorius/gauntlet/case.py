"""A case: a sequence of what an engine is asked, on a model or on a variant of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from risorius.effects import Touch
from risorius.effects.contact import Contact
from risorius.engine import Engine, Frame
from risorius.evaluators import Evaluator, Setting, Superposition
from risorius.gauntlet.going_back import GoingBack
from risorius.jaw import FloatArray
from risorius.model import ReducedModel
from risorius.penetration import PenetrationMeasure
from risorius.scene import Scene


class NotApplicableError(Exception):
    """The model lacks what a case is about; the text says what."""


@dataclass(frozen=True)
class Ask:
    """One call of `Engine.evaluate`.

    weights: an array, or whatever else a caller may give. refused: whether an InputError is the only right answer,
    may_refuse: whether it is one. counted: whether what was wrong with a message has been counted. free: whether
    nothing has pushed the face since the frame before, so that what moves may only lose energy.
    """

    weights: Any
    muscles: Mapping[str, float] | None = None
    step: float | None = None
    gravity: FloatArray | None = None
    touches: tuple[Touch, ...] = ()
    refused: bool = False
    may_refuse: bool = False
    counted: bool = True
    free: bool = False


@dataclass(frozen=True)
class Bench:
    """A model and what cases make of it."""

    model: ReducedModel
    scene: Scene = field(default_factory=Scene)

    @cached_property
    def engine(self) -> Engine:
        """Made when it is asked for the first time."""
        return Engine(self.model, self.scene)

    @cached_property
    def evaluator(self) -> Evaluator:
        """That of the engine, with a state of its own."""
        setting = self.engine.point.setting
        return self.model.evaluators[setting.method].at(setting)

    @cached_property
    def penetration(self) -> PenetrationMeasure | None:
        """Of skin in teeth and in the other lip; None where the engine has no contact."""
        contact = self.model.effects.get(Contact.name)
        if not isinstance(contact, Contact) or Contact.name not in self.engine.effects:
            return None
        return PenetrationMeasure(contact.geometry, self.model.poses, self.model.rest_vertices, self.model.triangles)

    @cached_property
    def going_back(self) -> GoingBack | None:
        """Of the mouth; None where the engine has no contact."""
        contact = self.engine.model.effects.get(Contact.name)
        if not isinstance(contact, Contact) or self.penetration is None:
            return None
        return GoingBack(self.engine.model, contact.at(self.engine.point.setting), self.penetration)

    @cached_property
    def rest(self) -> Frame:
        """The first frame of the engine."""
        return self.evaluate(Ask(np.zeros_like(self.lower)))

    @property
    def lower(self) -> FloatArray:
        """Smallest weight of each input."""
        return self.model.inputs.lower

    @property
    def rank(self) -> int:
        """Number of modes."""
        return self.model.rank - self.model.lifts

    def weights(self, named: Mapping[str, float]) -> FloatArray:
        """Weight array of named inputs; raises NotApplicableError for one that the model lacks."""
        missing = [name for name in named if name not in self.model.inputs.aliases]
        if missing:
            raise NotApplicableError(f"no input {', '.join(missing)}")
        return self.model.inputs.weights(named)

    def random(self, seed: int, share: float, count: int) -> FloatArray:
        """Random weights (count, inputs) of which a share is active."""
        rng = np.random.default_rng(seed)
        shape = count, len(self.lower)
        return np.where(rng.random(shape) < share, rng.uniform(self.lower, 1.0, shape), 0.0)

    def require_effect(self, name: str) -> None:
        """Raise NotApplicableError for an effect that the model lacks."""
        if name not in self.model.effects:
            raise NotApplicableError(f"no effect {name}")

    def running(self, setting: Setting) -> Bench:
        """Bench of the model as a setting runs it; raises NotApplicableError without its evaluator."""
        if setting.method not in self.model.evaluators:
            raise NotApplicableError(f"no evaluator {setting.method}")
        point = replace(self.model.points[-1], setting=setting)
        return Bench(replace(self.model, points=(point,)), Scene(nonlinear=setting.method != Superposition.name))

    def having(self, evaluator: Evaluator) -> Bench:
        """Bench of the model with another evaluator of the same name."""
        return Bench(replace(self.model, evaluators={**self.model.evaluators, evaluator.name: evaluator}))

    def parameters(self, ask: Ask) -> FloatArray:
        """Parameters (p,) of weights that are in order."""
        table = self.model.inputs
        named = isinstance(ask.weights, Mapping)
        weights = table.weights(ask.weights) if named else table.checked(ask.weights)
        return table.to_parameters(weights, ask.muscles)

    def evaluate(self, ask: Ask) -> Frame:
        """Ask the engine."""
        return self.engine.evaluate(
            ask.weights, muscles=ask.muscles, step=ask.step, gravity=ask.gravity, touches=ask.touches
        )


Frames: TypeAlias = Callable[[Bench], Iterable[Ask]]


def as_it_is(bench: Bench) -> Bench:
    """Leave the model as it is."""
    return bench


@dataclass(frozen=True)
class Case:
    """name, unique; group; what is asked; variant: what is made of the model before."""

    name: str
    group: str
    frames: Frames
    variant: Callable[[Bench], Bench] = field(default=as_it_is)


def asks(rows: Iterable[FloatArray]) -> list[Ask]:
    """One for each weight array."""
    return [Ask(row) for row in rows]
