"""What is compared: ways from parameters to vertices, each with what it cost to prepare."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from risorius.evaluators import Setting, Superposition
from risorius.jaw import FloatArray
from risorius.model import ReducedModel
from risorius.pipeline import Pipeline, pipelines

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
PHYSICS = Family("reduced physics", 2, "#CC79A7", "p")


@dataclass(frozen=True)
class OfflineCost:
    """Before the first frame: snapshots, CPU seconds of their solves and of training; None where not recorded."""

    snapshots: int | None
    solves: float | None
    training: float | None


@dataclass(frozen=True)
class Candidate:
    """One way of running a method: parameters (p,) to coordinates (r,), and on to the visible vertices (n, 3), metres.

    name: of the operating point, method: of what is run at it. What the two return may be overwritten by the next call.
    """

    name: str
    method: str
    family: Family
    coordinates: Callable[[FloatArray], npt.NDArray[np.floating]]
    vertices: Callable[[FloatArray], Vertices]
    offline: OfflineCost


class _OwnWay:
    """A pipeline of the model, as the engine has it."""

    def __init__(self, pipeline: Pipeline, rest: Vertices) -> None:
        self._pipeline, self._vertices = pipeline, np.empty_like(rest)

    def coordinates(self, parameters: FloatArray) -> FloatArray:
        self._pipeline.solve(parameters)
        return self._pipeline.coordinates

    def vertices(self, parameters: FloatArray) -> Vertices:
        self._pipeline.solve(parameters)
        self._pipeline.write(self._vertices)
        return self._vertices


def candidates_of(model: ReducedModel, offline: OfflineCost, singles: OfflineCost) -> list[Candidate]:
    """Every operating point of a model, the simplest first, with the costs of the model and of superposition alone."""
    settings = [point.setting for point in model.points]
    result = []
    for setting, pipeline in zip(settings, pipelines(model, settings), strict=True):
        way, family = _OwnWay(pipeline, model.rest_vertices), family_of(setting)
        cost = singles if family is BLENDSHAPES else offline
        result.append(Candidate(str(setting), setting.method, family, way.coordinates, way.vertices, cost))
    return sorted(result, key=lambda one: one.family.simplicity)


def family_of(setting: Setting) -> Family:
    """Family of one of our own operating points."""
    if setting.method == Superposition.name:
        return BLENDSHAPES
    return PHYSICS if setting.elements or setting.steps else MAPS
