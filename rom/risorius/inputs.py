"""From names and weights to the parameters of the physics: muscle activations and pose weights."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numba
import numpy as np
import numpy.typing as npt

from risorius.errors import InputError
from risorius.facs import ACTION_UNITS, ActionUnit
from risorius.intensities import LETTER_WEIGHTS
from risorius.jaw import FloatArray
from risorius.poses import POSE_LOWER

Weight: TypeAlias = float | str
"""A number, or a FACS letter A to E."""

SIDES = ("L", "R")


def without_side(name: str) -> str:
    """`zygomaticus_major_L` -> `zygomaticus_major`; a midline name is returned as it is."""
    return re.sub(r"_[LR]$", "", name)


@dataclass(frozen=True)
class InputTable:
    """Names of what a model understands, and the linear drive from inputs to parameters.

    muscles: names of the muscle activations in [0, 1], in the model's order.
    poses: names of the pose weights (jaw, upper lids), which follow the muscles in the parameter vector.
    only: names of the inputs that count; None for all that muscles and poses allow.
    """

    muscles: tuple[str, ...]
    poses: tuple[str, ...] = ()
    only: frozenset[str] | None = None

    @cached_property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameter vector: muscles, then poses."""
        return self.muscles + self.poses

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Inputs in order: one-sided action units, pose weights, muscles that no action unit drives."""
        units = [name for unit in ACTION_UNITS.values() for name in self._sided_names(unit) if self._counts(name)]
        driven = {muscle for name in units for muscle in self._drive_of(name)}
        left_over = [muscle for muscle in self.muscles if muscle not in driven]
        return (*units, *filter(self._counts, self.poses), *filter(self._counts, left_over))

    @cached_property
    def drive(self) -> FloatArray:
        """Matrix (inputs, parameters): parameters = clip(weights @ drive)."""
        matrix = np.zeros((len(self.names), len(self.parameters)))
        for row, name in enumerate(self.names):
            for parameter, share in self._drive_of(name).items():
                matrix[row, self._parameter_index[parameter]] = share
        return matrix

    @cached_property
    def lower(self) -> FloatArray:
        """Smallest admissible weight of each input, shape (inputs,)."""
        return np.array([POSE_LOWER.get(name, 0.0) for name in self.names])

    @cached_property
    def parameter_lower(self) -> FloatArray:
        """Smallest admissible value of each parameter, shape (parameters,)."""
        return np.array([POSE_LOWER.get(name, 0.0) for name in self.parameters])

    @cached_property
    def aliases(self) -> Mapping[str, tuple[int, ...]]:
        """Every accepted name -> positions in `names`: `AU12` -> those of `AU12_L` and `AU12_R`."""
        return _positions(self.names)

    @cached_property
    def muscle_aliases(self) -> Mapping[str, tuple[int, ...]]:
        """Every accepted name of a muscle -> positions in `muscles`, of both sides without one."""
        return _positions(self.muscles)

    def weights(self, values: Mapping[str, Weight]) -> FloatArray:
        """Weight array (inputs,) of named weights, numbers or FACS letters; names without a side set both sides.

        Raises InputError for an unknown name or a weight that is not a finite number in its range.
        """
        result = np.zeros(len(self.names))
        for name, value in values.items():
            positions = self.aliases.get(name)
            if positions is None:
                raise InputError(self.unknown(name))
            weight = self._checked(name, value, float(self.lower[positions[0]]))
            for position in positions:
                result[position] = weight
        return result

    def checked(self, weights: npt.ArrayLike) -> FloatArray:
        """Return a weight array in `names` order after checking length, finiteness and range; raises InputError."""
        array = np.asarray(weights, dtype=np.float64)
        if array.shape != (len(self.names),):
            raise InputError(
                f"weights: shape {array.shape} given, ({len(self.names)},) expected, "
                f"one weight for each of engine.inputs: {self.names[0]} ... {self.names[-1]}"
            )
        bad = _first_outside(array, self.lower)
        if bad < len(array):
            self._checked(self.names[bad], array[bad], float(self.lower[bad]))
        return array

    def to_parameters(self, weights: FloatArray, muscles: Mapping[str, Weight] | None = None) -> FloatArray:
        """Parameters (muscle activations and pose weights) of a weight array; several drives of one muscle saturate.

        Named muscle activations add to what the inputs ask of the same muscle, up to full activation.
        """
        parameters = np.minimum(np.maximum(weights @ self.drive, self.parameter_lower), 1.0)
        return np.minimum(parameters + self.activations(muscles), 1.0) if muscles else parameters

    def activations(self, muscles: Mapping[str, Weight]) -> FloatArray:
        """Parameter vector of named muscle activations; a name without a side sets both; raises InputError."""
        result = np.zeros(len(self.parameters))
        for name, value in muscles.items():
            positions = self.muscle_aliases.get(name)
            if positions is None:
                raise InputError(f"muscle {name!r} is not in this model; it has: {', '.join(self.muscles)}")
            weight = self._checked(name, value, 0.0)
            for position in positions:
                result[position] = weight
        return result

    def unknown(self, name: str) -> str:
        """Say why an input name is not understood, and what is."""
        unit = ACTION_UNITS.get(without_side(name))
        if unit is not None:
            needed = " or ".join({**unit.poses, **unit.muscles})
            return f"input {name!r} needs {needed}, which this model lacks; {self._known}"
        return f"input {name!r} is not known to this model; {self._known}"

    @cached_property
    def _known(self) -> str:
        return "it understands: " + ", ".join(dict.fromkeys(without_side(name) for name in self.names))

    @cached_property
    def _parameter_index(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(self.parameters)}

    def _counts(self, name: str) -> bool:
        return self.only is None or name in self.only

    def _sided_names(self, unit: ActionUnit) -> list[str]:
        name = f"AU{unit.number}"
        sided = [f"{name}_{side}" for side in SIDES if self._drive_of_unit(unit, side)]
        return sided or ([name] if self._drive_of_unit(unit, "") else [])

    def _drive_of_unit(self, unit: ActionUnit, side: str) -> dict[str, float]:
        """Shares of the parameters that a unit drives on one side, or with "" on the midline; empty without any."""
        for table in ({**unit.muscles, **unit.poses}, unit.substitutes):
            named = {f"{name}_{side}" if side else name: share for name, share in table.items()}
            present = {name: share for name, share in named.items() if name in self._parameter_index}
            if present:
                helpers = {f"{name}_{side}" if side else name: share for name, share in unit.helpers.items()}
                return present | {name: share for name, share in helpers.items() if name in self._parameter_index}
        return {}

    def _drive_of(self, name: str) -> Mapping[str, float]:
        unit = ACTION_UNITS.get(without_side(name))
        if unit is None:
            return {name: 1.0}
        return self._drive_of_unit(unit, name[-1] if name != without_side(name) else "")

    @staticmethod
    def _checked(name: str, value: Weight, lower: float) -> float:
        try:
            number = LETTER_WEIGHTS[value] if isinstance(value, str) and value in LETTER_WEIGHTS else float(value)
        except (TypeError, ValueError):
            raise InputError(
                f"{name}: weight {value!r} is not a number; give one in [{lower:g}, 1] or a FACS letter A to E"
            ) from None
        if not lower <= number <= 1.0:
            raise InputError(f"{name}: weight {number:g} is out of range; give a number in [{lower:g}, 1]")
        return number


def _positions(names: tuple[str, ...]) -> dict[str, tuple[int, ...]]:
    """Where each name is, and where those of both sides are that a name without a side stands for."""
    table: dict[str, tuple[int, ...]] = {name: (position,) for position, name in enumerate(names)}
    for name, positions in list(table.items()):
        stem = without_side(name)
        if stem != name:
            table[stem] = table.get(stem, ()) + positions
    return table


@numba.njit(cache=True)
def _first_outside(weights, lower):  # type: ignore[no-untyped-def]
    """Number of the first of weights (n,) that is no number from lower (n,) to 1; n where all are."""
    for k in range(len(weights)):
        if not lower[k] <= weights[k] <= 1.0:
            return k
    return len(weights)
