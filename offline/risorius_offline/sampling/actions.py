"""What a sampling design combines: the parameters of a face, grouped into actions, and pairs of opponents."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from risorius.inputs import InputTable, without_side
from risorius.jaw import FloatArray

OPPONENTS = (
    ("zygomaticus_major", "depressor_anguli_oris"),
    ("levator_anguli_oris", "depressor_anguli_oris"),
    ("zygomaticus_major", "orbicularis_oris_peripheralis"),
    ("risorius", "orbicularis_oris_peripheralis"),
    ("buccinator", "orbicularis_oris_peripheralis"),
    ("levator_labii_superioris", "orbicularis_oris_marginalis"),
    ("depressor_labii_inferioris", "orbicularis_oris_marginalis"),
    ("depressor_labii_inferioris", "mentalis"),
    ("frontalis_medialis", "corrugator_supercilii"),
    ("frontalis_medialis", "procerus"),
    ("frontalis_lateralis", "depressor_supercilii"),
    ("frontalis_lateralis", "orbicularis_oculi_orbitalis"),
    ("nasalis_alaris", "nasalis_transversa"),
)
"""Muscles that pull the same tissue in opposite directions, by their names without side."""


@dataclass(frozen=True)
class Action:
    """Positions of the parameters that belong together, left and right or one alone, and the least weight of each."""

    name: str
    positions: tuple[int, ...]
    lower: float

    def at(self, weight: float, count: int) -> FloatArray:
        """Parameters (count,) with this action alone, on both sides."""
        result = np.zeros(count)
        result[list(self.positions)] = weight
        return result


@dataclass(frozen=True)
class Actions:
    """Actions of the muscles, those of the poses, and pairs of muscle actions that oppose each other."""

    count: int
    muscles: tuple[Action, ...]
    poses: tuple[Action, ...]
    opponents: tuple[tuple[int, int], ...]

    @classmethod
    def of(cls, inputs: InputTable) -> Actions:
        """Group the parameters of an input table by side."""
        groups: dict[str, list[int]] = {}
        for position, name in enumerate(inputs.parameters):
            groups.setdefault(without_side(name), []).append(position)
        actions = [
            Action(name, tuple(positions), float(inputs.parameter_lower[positions[0]]))
            for name, positions in groups.items()
        ]
        muscles = tuple(action for action in actions if action.positions[0] < len(inputs.muscles))
        number = {action.name: k for k, action in enumerate(muscles)}
        pairs = tuple((number[a], number[b]) for a, b in OPPONENTS if a in number and b in number)
        return cls(len(inputs.parameters), muscles, tuple(action for action in actions if action not in muscles), pairs)
