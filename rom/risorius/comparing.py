"""Scenes side by side over a timeline: how far apart their faces are, and what each frame costs."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from risorius.engine import Engine
from risorius.jaw import FloatArray
from risorius.model import ReducedModel
from risorius.scene import Scene
from risorius.timeline import Timeline

TURN = 50  # frames of one scene in a row: enough to have its tables in the cache, as they are in use
WARM_UP = 20


@dataclass(frozen=True)
class Deviation:
    """Metres between vertices that two scenes show: the largest of all frames, and the mean of all."""

    maximum: float
    mean: float


class SceneRun:
    """A scene of a model, played along a timeline of the whole model's inputs. Not thread-safe.

    weights: (f, inputs) of the scene's inputs. A budget plays no part: chosen by the clock, a scene could differ from
    itself.
    """

    def __init__(self, model: ReducedModel, scene: Scene, timeline: Timeline) -> None:
        self.scene, self._timeline = scene, timeline
        self.engine = Engine(model, scene.model_copy(update={"budget": None}))
        self.weights = np.ascontiguousarray(timeline.weights_of(self.engine.inputs, model.inputs))
        self._timed, self._weighed = ("inertia" in self.engine.effects), ("gravity" in self.engine.effects)

    def __len__(self) -> int:
        return len(self.weights)

    def frame(self, number: int) -> npt.NDArray[np.float32]:
        """Vertices (n, 3) of a frame; frames follow each other, and the first has none before it."""
        step = float(self._timeline.steps[number]) if self._timed and number else None
        gravity = self._timeline.gravity[number] if self._weighed else None
        return self.engine.evaluate(self.weights[number], step=step, gravity=gravity).vertices


def deviations(reference: SceneRun, others: Sequence[SceneRun]) -> list[Deviation]:
    """How far the vertices that each of the others shares with a reference are from those, over their timeline."""
    shared = [
        np.intersect1d(reference.engine.vertex_numbers, one.engine.vertex_numbers, return_indices=True)[1:]
        for one in others
    ]
    maximum, total = np.zeros(len(others)), np.zeros(len(others))
    for number in range(len(reference)):
        expected = reference.frame(number)
        for k, (one, (theirs, ours)) in enumerate(zip(others, shared, strict=True)):
            apart = np.linalg.norm(one.frame(number)[ours] - expected[theirs], axis=1)
            maximum[k], total[k] = max(maximum[k], float(apart.max())), total[k] + float(apart.mean())
    return [Deviation(*pair) for pair in zip(maximum.tolist(), (total / len(reference)).tolist(), strict=True)]


def frame_times(runs: Sequence[SceneRun]) -> FloatArray:
    """Seconds (runs, f) of every frame of one timeline, scenes in turn: what else the machine does falls on all."""
    frames = len(runs[0])
    seconds, clock = np.empty((len(runs), frames)), time.perf_counter
    for run in runs:
        for number in range(min(WARM_UP, frames)):
            run.frame(number)
    for start in range(0, frames, TURN):
        for run, row in zip(runs, seconds, strict=True):
            for number in range(start, min(start + TURN, frames)):
                begin = clock()
                run.frame(number)
                row[number] = clock() - begin
    return seconds
