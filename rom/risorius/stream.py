"""Weights that arrive on a stream: nothing in them may raise or reach the physics unchecked."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable

import numpy as np

from risorius.inputs import InputTable
from risorius.jaw import FloatArray

NAMES_KEPT = 64  # a sender of ever new names must not fill the memory


class InputGate:
    """Turns named values from a topic or a page into an admissible weight array.

    An unknown name or a value that is not finite is left out, a value out of range is clamped; `counts` tells how
    often each happened (`unknown`, `not_finite`, `clamped`), `unknown_names` some of the names.
    """

    def __init__(self, table: InputTable) -> None:
        self._table = table
        self.counts: Counter[str] = Counter()
        self.unknown_names: set[str] = set()

    def weights(self, named: Iterable[tuple[str, float]], base: FloatArray | None = None) -> FloatArray:
        """Weight array (inputs,) of named values on top of `base` (all zero when absent)."""
        result = np.zeros(len(self._table.names)) if base is None else base.copy()
        for name, value in named:
            positions = self._table.aliases.get(name)
            if positions is None:
                self.counts["unknown"] += 1
                if len(self.unknown_names) < NAMES_KEPT:
                    self.unknown_names.add(name)
            elif not math.isfinite(value):
                self.counts["not_finite"] += 1
            else:
                lowest = self._table.lower[positions[0]]
                self.counts["clamped"] += not lowest <= value <= 1.0
                result[list(positions)] = min(max(value, lowest), 1.0)
        return result
