"""What the page's sliders are called and how they are grouped."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from risorius.facs import ACTION_UNITS
from risorius.inputs import InputTable, without_side
from risorius.jaw import JAW_INPUTS

_LAST_UPPER_FACE_UNIT = 7  # FACS: AU1 to AU7 are of the upper face
GROUPS = ("Upper face", "Lower face", "Jaw", "Muscles")


@dataclass(frozen=True)
class Slider:
    """One slider: `name` moves all of `inputs`; a slider of both sides comes with one for each side."""

    name: str
    label: str
    group: str
    lower: float
    inputs: tuple[str, ...]


def sliders_of(table: InputTable) -> Iterator[Slider]:
    """Yield the sliders of a model in the order of its inputs, one for each pair of sides."""
    for stem in dict.fromkeys(without_side(name) for name in table.names):
        positions = table.aliases[stem]
        inputs = tuple(table.names[i] for i in positions)
        yield Slider(
            name=stem if len(inputs) > 1 else inputs[0],
            label=_label(stem),
            group=_group(stem),
            lower=float(table.lower[positions[0]]),
            inputs=inputs,
        )


def _label(stem: str) -> str:
    unit = ACTION_UNITS.get(stem)
    return unit.name if unit else stem.replace("_", " ")


def _group(stem: str) -> str:
    unit = ACTION_UNITS.get(stem)
    if stem in JAW_INPUTS or (unit and unit.jaw):
        return "Jaw"
    if unit is None:
        return "Muscles"
    return "Upper face" if unit.number <= _LAST_UPPER_FACE_UNIT else "Lower face"
