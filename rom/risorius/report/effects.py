"""What each effect, output and restriction of a scene costs, and how wrong the face is without it."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from risorius.comparing import SceneRun, deviations, frame_times
from risorius.effects import EFFECTS
from risorius.model import ReducedModel
from risorius.scene import Scene
from risorius.timeline import Timeline


@dataclass(frozen=True)
class Price:
    """change: what another scene does otherwise. seconds: that its frames take more, the median of paired differences.

    maximum, mean: metres, how far off the vertices are that it shares with the scene, the largest and the mean.
    """

    change: str
    seconds: float
    maximum: float
    mean: float


@dataclass(frozen=True)
class Prices:
    """seconds: median of a frame of the scene, over so many frames of a timeline; rows: of every change to it."""

    timeline: str
    frames: int
    seconds: float
    rows: tuple[Price, ...]


def prices(model: ReducedModel, scene: Scene, timeline: Timeline) -> Prices:
    """Measure a scene and every scene that differs from it in one thing, frame by frame in turn."""
    reference = SceneRun(model, scene, timeline)
    changes = _changes(scene, reference)
    others = [SceneRun(model, other, timeline) for other in changes.values()]
    seconds, *rest = frame_times([reference, *others])
    found = deviations(reference, others)
    rows = [
        Price(change, float(np.median(own - seconds)), one.maximum, one.mean)
        for change, own, one in zip(changes, rest, found, strict=True)
    ]
    return Prices(timeline.name, len(timeline.weights), float(np.median(seconds)), tuple(rows))


def _changes(scene: Scene, reference: SceneRun) -> dict[str, Scene]:
    """Scenes that differ in one thing, by what that is; the same scene again tells what the clock resolves."""
    changes = {"the same": scene}
    off = [name for name in EFFECTS if name in reference.engine.effects]
    off += ["nonlinear"] if scene.nonlinear else []
    off += ["jaw"] if scene.inputs is None and reference.engine.model.poses.jaw is not None else []
    changes |= {f"without {name}": scene.model_copy(update={name: False}) for name in off}
    for output in scene.outputs:
        if output != "vertices":
            fewer = tuple(one for one in scene.outputs if one != output)
            changes[f"without {output}"] = scene.model_copy(update={"outputs": fewer})
    for field, words in (("inputs", "all inputs"), ("region", "the whole face"), ("resolution", "every vertex")):
        whole = Scene.model_fields[field].default
        if getattr(scene, field) != whole:
            changes[f"with {words}"] = scene.model_copy(update={field: whole})
    return changes


def as_csv(found: Prices) -> str:
    """Rows in SI units."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["change", "seconds_more", "largest_difference_m", "mean_difference_m"])
    writer.writerows([row.change, f"{row.seconds:.3e}", f"{row.maximum:.3e}", f"{row.mean:.3e}"] for row in found.rows)
    return text.getvalue()


def sentences(found: Prices) -> Sequence[str]:
    """Lines for people: microseconds and millimetres."""
    head = f"the scene: {1e6 * found.seconds:.1f} us a frame, over {found.frames} frames of {found.timeline}"
    lines = [
        f"{row.change}: {1e6 * row.seconds:+.1f} us ({100 * row.seconds / found.seconds:+.0f} %), "
        f"off by {1e3 * row.maximum:.3f} mm at most, {1e3 * row.mean:.3f} mm on average"
        for row in found.rows
    ]
    return [head, *lines]
