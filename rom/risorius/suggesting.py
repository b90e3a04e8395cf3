"""The cheapest scene that stays close enough to another one over a timeline."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from risorius.comparing import SceneRun, deviations, frame_times
from risorius.effects import EFFECTS
from risorius.errors import InputError
from risorius.inputs import without_side
from risorius.model import ReducedModel
from risorius.scene import Scene
from risorius.timeline import Timeline


@dataclass(frozen=True)
class Suggestion:
    """scene; error: metres, the largest of a vertex over the timeline; seconds, whole: median of a frame, and that of
    the scene it is compared with, measured in turn.
    """

    scene: Scene
    error: float
    seconds: float
    whole: float


def suggest(model: ReducedModel, timeline: Timeline, most: float, base: Scene | None = None) -> Suggestion:
    """Return the cheapest scene whose vertices stay within `most` metres of those of `base`, or of everything.

    Every choice of effects that the scene has is tried, nonlinearity among them; then inputs are left out, those that
    change least first. Raises InputError for a distance that is not positive.
    """
    if not most > 0.0:
        raise InputError(f"largest error {most:g}; give a positive length")
    base = base or Scene()
    reference = SceneRun(model, base, timeline)
    used = _used_inputs(reference, timeline)
    plain = base.model_copy(update={"inputs": used})
    runs = [SceneRun(model, scene, timeline) for scene in _choices(plain, reference)]
    found = deviations(reference, runs)
    good = [run for run, one in zip(runs, found, strict=True) if one.maximum <= most]
    cheapest = good[int(np.median(frame_times(good), axis=1).argmin())].scene
    scene = _with_fewer_inputs(model, reference, cheapest, timeline, most)
    last = SceneRun(model, scene, timeline)
    seconds, whole = np.median(frame_times([last, reference]), axis=1)
    return Suggestion(scene, deviations(reference, [last])[0].maximum, float(seconds), float(whole))


def _used_inputs(reference: SceneRun, timeline: Timeline) -> tuple[str, ...]:
    """Names of the inputs of a scene that a timeline moves; those of two sides by one name, where both are moved."""
    table = reference.engine.model.inputs
    moved = {name for name, weights in zip(table.names, reference.weights.T, strict=True) if weights.any()}
    if not moved:
        raise InputError(f"{timeline.name}: moves no input of the scene; its inputs: {', '.join(table.names)}")
    names = dict[str, None]()
    for name in (name for name in table.names if name in moved):
        both = {table.names[position] for position in table.aliases[without_side(name)]} <= moved
        names[without_side(name) if both else name] = None
    return tuple(names)


def _choices(plain: Scene, reference: SceneRun) -> list[Scene]:
    """All choices of what the scene has, the whole of it first."""
    switches = [name for name in EFFECTS if name in reference.engine.effects]
    switches += ["nonlinear"] if plain.nonlinear else []
    off = [names for count in range(len(switches) + 1) for names in combinations(switches, count)]
    return [plain.model_copy(update=dict.fromkeys(names, False)) for names in off]


def _with_fewer_inputs(
    model: ReducedModel, reference: SceneRun, scene: Scene, timeline: Timeline, most: float
) -> Scene:
    """Leave inputs out, those with the least weight first, as long as the face stays within `most` metres."""
    aliases = reference.engine.model.inputs.aliases

    def largest(name: str) -> float:
        return float(np.abs(reference.weights[:, list(aliases[name])]).max())

    for name in sorted(scene.inputs or (), key=largest):
        fewer = scene.model_copy(update={"inputs": tuple(one for one in scene.inputs or () if one != name)})
        if not fewer.inputs:
            return scene
        if deviations(reference, [SceneRun(model, fewer, timeline)])[0].maximum > most:
            return scene
        scene = fewer
    return scene
