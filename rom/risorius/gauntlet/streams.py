"""What arrives on a topic: none of it may raise, all of it is counted."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from risorius.gauntlet.case import Ask, Bench, Case
from risorius.stream import InputGate

VALUES: dict[str, Any] = {
    "not a number": np.nan, "infinity": np.inf, "minus infinity": -np.inf, "1e308": 1e308, "-1e308": -1e308,
    "a whole number too large for a float": 10**400, "a text": "much", "nothing": None, "a list": [1.0],
}  # fmt: skip
NAMES: dict[str, Any] = {
    "unknown": "AU999", "empty": "", "of 100 000 letters": "A" * 100_000,
    "that is a number": 12, "with a NUL": "AU12\0",
}  # fmt: skip
MESSAGES = 200


def stream_cases() -> list[Case]:
    """Bad values and names among good ones, and noise."""
    cases = [Case(f"value: {name}", "stream", partial(_value, value)) for name, value in VALUES.items()]
    cases += [Case(f"name {shown}", "stream", partial(_name, name)) for shown, name in NAMES.items()]
    cases += [
        Case("more names than values", "stream", partial(_mismatched, 1)),
        Case("more values than names", "stream", partial(_mismatched, -1)),
        Case("every name twice, the last value counts", "stream", _twice),
        Case("noise from -1e6 to 1e6", "stream", _noise),
    ]
    return cases


def _value(value: Any, bench: Bench) -> list[Ask]:
    """A bad value for each input, the others at 0.3."""
    names, rows = bench.model.inputs.names, []
    for bad in names:
        gate = InputGate(bench.model.inputs)
        weights = gate.weights([(name, value if name == bad else 0.3) for name in names])
        rows.append(Ask(weights, counted=gate.counts.total() == 1))
    return rows


def _name(name: Any, bench: Bench) -> list[Ask]:
    gate = InputGate(bench.model.inputs)
    weights = gate.weights([(bench.model.inputs.names[0], 0.3), (name, 1.0)])
    return [Ask(weights, counted=gate.counts == {"unknown": 1, "clamped": 0})]


def _mismatched(extra: int, bench: Bench) -> list[Ask]:
    names = bench.model.inputs.names
    gate = InputGate(bench.model.inputs)
    found = gate.message(names, [0.5] * (len(names) - extra))
    return [Ask(np.zeros_like(bench.lower), counted=found is None and gate.counts["mismatched"] == 1)]


def _twice(bench: Bench) -> list[Ask]:
    named = [(name, value) for value in (1.0, 0.2) for name in bench.model.inputs.names]
    weights = InputGate(bench.model.inputs).weights(named)
    return [Ask(weights, counted=bool((weights == 0.2).all()))]


def _noise(bench: Bench) -> list[Ask]:
    rng, gate, names = np.random.default_rng(12), InputGate(bench.model.inputs), bench.model.inputs.names
    rows = []
    for _ in range(MESSAGES):
        values = rng.uniform(-1e6, 1e6, len(names))
        before = gate.counts.total()
        rows.append(Ask(gate.weights(zip(names, values, strict=True)), counted=gate.counts.total() > before))
    return rows
