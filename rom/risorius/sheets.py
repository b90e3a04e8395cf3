"""What contact sheets of a model show: action units, expressions, motions of the jaw, single muscles."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from risorius.expressions import EMOTIONS, FIGURES
from risorius.facs import ACTION_UNITS
from risorius.inputs import InputTable

FULL = 1.0

# Figures 7.13 to 7.16 of the seed.
FIGURE_MUSCLES = (
    "zygomaticus_major_L",
    "depressor_anguli_oris_R",
    "levator_labii_superioris_R",
    "mentalis_L",
)


@dataclass(frozen=True)
class Face:
    """One face of a sheet: its label, and the weights of inputs and activations of muscles that make it."""

    label: str
    weights: Mapping[str, float] = field(default_factory=dict)
    muscles: Mapping[str, float] = field(default_factory=dict)


def _units(table: InputTable) -> list[Face]:
    """Return every action unit that the model has, both sides at full weight."""
    return [Face(f"{name}  {unit.name}", {name: FULL}) for name, unit in ACTION_UNITS.items() if name in table.aliases]


def _expressions(table: InputTable) -> list[Face]:
    """Return the six emotions and the seed's two figures; a label says what a model lacks."""
    faces = []
    for emotion in EMOTIONS:
        weights = {name: weight for name, weight in emotion.weights.items() if name in table.aliases}
        missing = [name for name in emotion.weights if name not in weights]
        faces.append(Face(emotion.name + (f", without {', '.join(missing)}" if missing else ""), weights))
    figures = [Face(figure.name, muscles=figure.within(table.muscles)) for figure in FIGURES]
    return [face for face in (*faces, *figures) if face.weights or face.muscles]


def _jaw(table: InputTable) -> list[Face]:
    """Return the motions of Figure 7.12; right and left are the person's own."""
    moves = {"forward": ("jaw_forward", FULL), "right": ("jaw_sideways", -FULL), "down": ("jaw_open", FULL)}
    moves["left"] = ("jaw_sideways", FULL)
    return [Face(f"jaw {way}", {name: weight}) for way, (name, weight) in moves.items() if name in table.aliases]


def _muscles(table: InputTable) -> list[Face]:
    """Return the single muscles of the seed's figures, then all others of the person's left or the midline."""
    figured = [name for name in FIGURE_MUSCLES if name in table.muscles]
    others = [name for name in table.muscles if not name.endswith("_R") and name not in figured]
    return [Face(name.replace("_", " "), muscles={name: FULL}) for name in (*figured, *others)]


SHEETS: Mapping[str, Callable[[InputTable], Sequence[Face]]] = MappingProxyType(
    {"units": _units, "expressions": _expressions, "jaw": _jaw, "muscles": _muscles}
)


def faces_of(sheet: str, table: InputTable) -> list[Face]:
    """Return the faces of a sheet (a name in SHEETS) that a model can make, after the neutral one."""
    return [Face("neutral"), *SHEETS[sheet](table)]
