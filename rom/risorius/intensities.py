"""FACS scores: the letters A to E, and strings such as `1C+2C+5B+26` or `L12D`.

FACS scores intensity in five ordinal steps. Equal steps of weight are our convention, the only one in this package:
OpenFace's 1 to 5 are the same five steps.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

from risorius.errors import InputError
from risorius.facs import ACTION_UNITS

LETTER_WEIGHTS: Mapping[str, float] = MappingProxyType({"A": 0.2, "B": 0.4, "C": 0.6, "D": 0.8, "E": 1.0})
TRACE, SLIGHT, MARKED, SEVERE, MAXIMUM = LETTER_WEIGHTS.values()
UNSCORED = SEVERE
"""Weight of a unit without a letter."""

_UNIT = re.compile(r"([LR]?)(\d+)([A-E]?)")


def action_units(text: str) -> dict[str, float]:
    """Weights by input name of a FACS score: `1C+2C+5B+26` -> AU1, AU2, AU5, AU26; `L12D` -> AU12_L.

    L and R are the person's own sides, as in FACS; an empty score is the neutral face. Raises InputError for a part
    that is not one, for a unit without a row in facs.py and for one that is scored twice.
    """
    weights: dict[str, float] = {}
    for part in text.replace(" ", "").split("+") if text.strip() else ():
        match = _UNIT.fullmatch(part)
        if not match:
            raise InputError(
                f"FACS score {text!r}: {part!r} is not [L|R]NUMBER[A-E]; write for example 1C+2C+5B+26 or L12D"
            )
        side, number, letter = match.groups()
        unit = f"AU{int(number)}"
        if unit not in ACTION_UNITS:
            raise InputError(f"FACS score {text!r}: {unit} is not known; known are {', '.join(ACTION_UNITS)}")
        name = f"{unit}_{side}" if side else unit
        if name in weights:
            raise InputError(f"FACS score {text!r}: {part!r} scores its unit a second time; score it once")
        weights[name] = LETTER_WEIGHTS.get(letter, UNSCORED)
    return weights


def score(weights: Mapping[str, float]) -> str:
    """FACS score of action-unit weights, each at its nearest letter; what is nearer to 0 than to A is left out.

    Raises InputError for an input that is not an action unit: FACS has no score for it.
    """
    parts = []
    for name, weight in weights.items():
        unit, _, side = name.partition("_")
        if unit not in ACTION_UNITS or side not in ("", "L", "R"):
            raise InputError(f"{name}: not an action unit, FACS has no score for it; leave it out")
        if not 0.0 <= weight <= 1.0:
            raise InputError(f"{name}: weight {weight:g} is out of range; give a number in [0, 1]")
        step = round(weight * len(LETTER_WEIGHTS))
        if step:
            parts.append(f"{side}{ACTION_UNITS[unit].number}{tuple(LETTER_WEIGHTS)[step - 1]}")
    return "+".join(parts)
