"""Weights that arrive on a stream: nothing in them may raise or reach the physics unchecked."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from risorius.inputs import InputTable
from risorius.jaw import FloatArray

NAMES_KEPT = 64  # a sender of ever new names must not fill the memory
LETTERS_KEPT = 80


class InputGate:
    """Turns named values from a topic or a page into an admissible weight array.

    A message whose names and values do not match in number is dropped. Of others, an unknown name or a value that is
    no finite number is left out, a value out of range is clamped. `counts` tells how often each happened
    (`mismatched`, `unknown`, `not_finite`, `clamped`), `unknown_names` some of the names.
    """

    def __init__(self, table: InputTable) -> None:
        self._table = table
        self.counts: Counter[str] = Counter()
        self.unknown_names: set[str] = set()

    def message(self, names: Sequence[Any], values: Sequence[Any]) -> FloatArray | None:
        """Weight array (inputs,) of names and as many values; None where they are not as many."""
        if len(names) != len(values):
            self.counts["mismatched"] += 1
            return None
        return self.weights(zip(names, values, strict=True))

    def weights(self, named: Iterable[tuple[Any, Any]], base: FloatArray | None = None) -> FloatArray:
        """Weight array (inputs,) of named values on top of `base` (all zero when absent)."""
        result = np.zeros(len(self._table.names)) if base is None else base.copy()
        for name, value in named:
            positions = self._table.aliases.get(name) if isinstance(name, str) else None
            number = _number(value)
            if positions is None:
                self._note_unknown(str(name))
            elif not math.isfinite(number):
                self.counts["not_finite"] += 1
            else:
                lowest = self._table.lower[positions[0]]
                self.counts["clamped"] += not lowest <= number <= 1.0
                result[list(positions)] = min(max(number, lowest), 1.0)
        return result

    def _note_unknown(self, name: str) -> None:
        self.counts["unknown"] += 1
        if len(self.unknown_names) < NAMES_KEPT:
            self.unknown_names.add(name[:LETTERS_KEPT])


def _number(value: Any) -> float:
    """A float, not a number where the value is none or too large for one."""
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return math.nan
