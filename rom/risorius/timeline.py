"""Weights over time: of a CSV file, or of the loop of expressions."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from risorius import openface
from risorius.effects.effect import UPRIGHT
from risorius.errors import InputError
from risorius.expressions import expression_loop
from risorius.inputs import InputTable
from risorius.jaw import FloatArray
from risorius.stream import InputGate

RATE = 60.0  # frames per second of a loop
TIMES = ("timestamp", "time", "seconds")  # columns that hold seconds
_OPENFACE = "_r"  # ends the names of its intensities


@dataclass(frozen=True)
class Timeline:
    """name: where it comes from. weights (f, inputs) in the order of a model's inputs; steps (f,): seconds since the
    frame before, of the first the same as of the second. gravity (f, 3): m/s2 in the frame of the head.
    """

    name: str
    weights: FloatArray
    steps: FloatArray
    gravity: FloatArray

    @classmethod
    def read(cls, path: str | Path, table: InputTable) -> Timeline:
        """Read a CSV file: of OpenFace, or with columns named as inputs; the time in a column `timestamp` or `time`.

        Inputs that the model lacks are left out. A head without OpenFace's `pose_Rx`, `pose_Ry`, `pose_Rz` is upright,
        and the camera always is. Raises InputError that names file and line.
        """
        path = Path(path)
        if not path.is_file():
            raise InputError(f"{path}: no such file; give a CSV file of OpenFace, or one with columns like AU12")
        gate, times, weights, gravity = InputGate(table), list[float](), list[FloatArray](), list[FloatArray]()
        with path.open(newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file, skipinitialspace=True)
            for row in reader:
                try:
                    times.append(_time(row, len(times)))
                    weights.append(gate.weights(_weights(row, table).items()))
                    gravity.append(openface.gravity(row) if openface.ROTATIONS[0] in row else UPRIGHT)
                except InputError as error:
                    raise InputError(f"{path}: line {reader.line_num}: {error}") from error
        if len(weights) < 2:
            raise InputError(f"{path}: {len(weights)} frames; a timeline has at least two")
        return cls(path.name, np.array(weights), _steps(times, path), np.array(gravity))

    @classmethod
    def of_expressions(cls, table: InputTable) -> Timeline:
        """One turn of the loop of those expressions that the inputs can make."""
        loop = expression_loop(table.names)
        times = np.arange(0.0, loop.period, 1.0 / RATE)
        weights = np.array([table.weights(loop.weights(seconds)) for seconds in times])
        steps, gravity = np.full(len(times), 1.0 / RATE), np.tile(UPRIGHT, (len(times), 1))
        return cls("the loop of expressions", weights, steps, gravity)

    def weights_of(self, names: Sequence[str], table: InputTable) -> FloatArray:
        """Weights (f, k) of some inputs, or of muscles, whose weights are the activations that the inputs ask for."""
        if set(names) <= set(table.names):
            return self.weights[:, [table.names.index(name) for name in names]]
        activations = np.array([table.to_parameters(row) for row in self.weights])
        both = dict(zip((*table.parameters, *table.names), np.hstack([activations, self.weights]).T, strict=True))
        return np.column_stack([both[name] for name in names])


def _weights(row: dict[str, str], table: InputTable) -> dict[str, float]:
    if any(name is not None and name.strip().endswith(_OPENFACE) for name in row):
        return openface.action_units({name: value for name, value in row.items() if name is not None})
    known = {name: value for name, value in row.items() if name in table.aliases}
    if not known:
        raise InputError(f"no column is an input of the model among {', '.join(map(str, row)) or 'none'}")
    return {name: _number(name, value) for name, value in known.items()}


def _time(row: dict[str, str], number: int) -> float:
    named = next((name for name in TIMES if row.get(name)), None)
    return number / RATE if named is None else _number(named, row[named])


def _number(name: str, value: str) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise InputError(f"{name}: {value!r} is not a number; leave the row out")
    return number


def _steps(times: list[float], path: Path) -> FloatArray:
    steps = np.diff(times)
    if not (steps > 0.0).all():
        raise InputError(f"{path}: frame {int(np.argmin(steps > 0.0)) + 2}: time does not go on; put frames in order")
    return np.append(steps[:1], steps)
