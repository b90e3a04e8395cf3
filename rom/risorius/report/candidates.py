"""What is compared: ways from parameters to vertices, each with what it cost to prepare."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from risorius.evaluators import LEARNED, Evaluator, Superposition
from risorius.jaw import FloatArray
from risorius.model import ReducedModel
from risorius.reconstruction import Reconstruction, reconstruction

Vertices = npt.NDArray[np.float32]


@dataclass(frozen=True)
class Family:
    """Methods of one kind. simplicity: the lower, the less there is to build and to trust; colour, marker: drawn."""

    name: str
    simplicity: int
    colour: str
    marker: str


# Colours by Okabe and Ito (2008), told apart by colour-blind people too.
BLENDSHAPES = Family("linear blendshapes", 0, "#E69F00", "s")
MAPS = Family("learned map", 1, "#0072B2", "o")
PHYSICS = Family("reduced physics", 2, "#CC79A7", "P")


@dataclass(frozen=True)
class OfflineCost:
    """Before the first frame: snapshots, CPU seconds of their solves and of training; None where not recorded."""

    snapshots: int | None
    solves: float | None
    training: float | None


@dataclass(frozen=True)
class Candidate:
    """One method: parameters (p,) to coordinates (r,), and all the way to the visible vertices (n, 3), metres.

    What the two return may be overwritten by the next call.
    """

    name: str
    family: Family
    coordinates: Callable[[FloatArray], npt.NDArray[np.floating]]
    vertices: Callable[[FloatArray], Vertices]
    offline: OfflineCost


class _OwnMethod:
    """An evaluator of a model, without the bookkeeping of the engine around it."""

    def __init__(self, model: ReducedModel, evaluator: Evaluator, skin: Reconstruction) -> None:
        self._evaluator, self._skin, self._poses = evaluator, skin, model.poses
        self._muscles = len(model.inputs.muscles)
        self._coordinates = np.zeros(model.rank)
        self._lifts, self._modal = self._coordinates[: model.lifts], self._coordinates[model.lifts :]
        self._vertices = np.empty_like(model.rest_vertices)

    def coordinates(self, parameters: FloatArray) -> FloatArray:
        self._poses.lift_coordinates(parameters[self._muscles :], out=self._lifts)
        self._evaluator.coordinates(parameters, self._modal)
        return self._coordinates

    def vertices(self, parameters: FloatArray) -> Vertices:
        self._skin.write(self.coordinates(parameters), self._vertices)
        return self._vertices


def candidates_of(model: ReducedModel, offline: OfflineCost, singles: OfflineCost) -> list[Candidate]:
    """Every evaluator of a model, the simplest first; costs of the model, and of superposition's singles."""
    skin = reconstruction(model.carried_basis, model.rest_vertices)
    result = []
    for name, evaluator in model.evaluators.items():
        own = _OwnMethod(model, evaluator, skin)
        cost = singles if name == Superposition.name else offline
        result.append(Candidate(name, _family(name), own.coordinates, own.vertices, cost))
    return sorted(result, key=lambda one: one.family.simplicity)


def _family(name: str) -> Family:
    if name == Superposition.name:
        return BLENDSHAPES
    return MAPS if name in LEARNED else PHYSICS
