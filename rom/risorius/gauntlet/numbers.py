"""Numbers at the ends of floating point, and what an engine has to refuse."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from risorius.gauntlet.case import Ask, Bench, Case

SINGLE, DOUBLE = np.finfo(np.float32), np.finfo(np.float64)
ADMISSIBLE: dict[str, Any] = {
    "smallest normal number of single precision": SINGLE.tiny,
    "smallest number of single precision": SINGLE.smallest_subnormal,
    "smallest normal number of double precision": DOUBLE.tiny,
    "smallest number of double precision": DOUBLE.smallest_subnormal,
    "denormal 1e-310": 1e-310,
    "minus zero": -0.0,
    "largest below 1, single precision": 1.0 - SINGLE.epsneg,
    "largest below 1, double precision": 1.0 - DOUBLE.epsneg,
    "epsilon of single precision": SINGLE.eps,
}
REFUSED: dict[str, Any] = {
    "not a number": np.nan,
    "infinity": np.inf,
    "minus infinity": -np.inf,
    "largest of single precision": SINGLE.max,
    "largest of double precision": DOUBLE.max,
    "smallest above 1": 1.0 + DOUBLE.eps,
    "minus 2": -2.0,
}


def number_cases() -> list[Case]:
    """Every input at such a number, alone and with the others at 1."""
    cases = [Case(f"weights: {name}", "numbers", partial(_admissible, value)) for name, value in ADMISSIBLE.items()]
    cases += [Case(f"refused: {name}", "numbers", partial(_refused, value)) for name, value in REFUSED.items()]
    cases += [
        Case("weights in single precision", "numbers", partial(_as_type, np.float32)),
        Case("weights as whole numbers", "numbers", partial(_as_type, np.int8)),
        Case("weights as a list", "numbers", lambda bench: [Ask(list(row)) for row in bench.random(9, 0.3, 10)]),
        Case("refused: an array too short", "numbers", lambda bench: _around(bench, np.zeros(len(bench.lower) - 1))),
        Case("refused: an array too long", "numbers", lambda bench: _around(bench, np.zeros(len(bench.lower) + 1))),
        Case("refused: a matrix", "numbers", lambda bench: _around(bench, np.zeros((1, len(bench.lower))))),
        Case("refused: a name that is not known", "numbers", lambda bench: _around(bench, {"AU999": 1.0})),
        Case("refused: a weight that is a text", "numbers", lambda bench: _around(bench, {_first(bench): "much"})),
        Case("refused: a weight that is nothing", "numbers", lambda bench: _around(bench, {_first(bench): None})),
    ]
    return cases


def _first(bench: Bench) -> str:
    return bench.model.inputs.names[0]


def _admissible(value: float, bench: Bench) -> list[Ask]:
    alone, every = np.eye(len(bench.lower)), np.ones_like(bench.lower)
    return [Ask(value * every), *(Ask(np.where(one > 0.0, value, 1.0)) for one in alone)]


def _refused(value: float, bench: Bench) -> list[Ask]:
    row = np.zeros_like(bench.lower)
    row[-1] = value
    return _around(bench, row)


def _around(bench: Bench, bad: Any) -> list[Ask]:
    """What is refused between two frames that are not."""
    good = bench.random(10, 0.3, 1)[0]
    return [Ask(good), Ask(bad, refused=True), Ask(good)]


def _as_type(kind: type, bench: Bench) -> list[Ask]:
    return [Ask(row.astype(kind)) for row in bench.random(11, 0.3, 10)]
