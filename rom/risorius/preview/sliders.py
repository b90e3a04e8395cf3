"""What the page's sliders are called and how they are grouped."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from risorius.facs import ACTION_UNITS
from risorius.inputs import InputTable, without_side
from risorius.jaw import JawMotion
from risorius.lids import LidMotion

# FACS: AU1 to AU7 are of the upper face, AU41 to AU46 of the eyes in it.
_UPPER_FACE = {*range(1, 8), *range(41, 47)}
_LIDS = {without_side(name) for name in LidMotion.inputs}
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
    if stem in JawMotion.inputs or (unit and not set(JawMotion.inputs).isdisjoint(unit.poses)):
        return "Jaw"
    if stem in _LIDS or (unit and unit.number in _UPPER_FACE):
        return "Upper face"
    return "Lower face" if unit else "Muscles"
