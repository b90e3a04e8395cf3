"""Which parameter vectors to solve: single actions, symmetric actions and sparse combinations, seeded.

A sample depends on the seed and its own number only, so a longer run contains a shorter one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from risorius.inputs import InputTable, without_side
from risorius.jaw import FloatArray, JawMotion
from risorius.lids import LidMotion

LARGEST_COMBINATION = 4
SYMMETRIC, ONE_SIDED = 0.6, 0.2  # the rest has a weight of its own on either side
WITH_JAW, WITH_LIDS = 0.4, 0.4
TRAINING_STREAM, HELD_OUT_STREAM = 0, 1


@dataclass(frozen=True)
class SamplingDesign:
    """parameters (s, p) to solve; held_out (s,) marks those that training never reads."""

    parameters: FloatArray
    held_out: npt.NDArray[np.bool_]


def design(inputs: InputTable, count: int, held_out: int, seed: int) -> SamplingDesign:
    """Single actions, then symmetric ones, then random combinations up to `count`, and `held_out` more combinations.

    At least all single actions at weight 1 are included, however small `count` is.
    """
    fixed = _single_actions(inputs)
    remaining = max(0, count - len(fixed))
    training = [_combination(inputs, (seed, TRAINING_STREAM, k)) for k in range(remaining)]
    testing = [_combination(inputs, (seed, HELD_OUT_STREAM, k)) for k in range(held_out)]
    parameters = np.array([*fixed, *training, *testing])
    return SamplingDesign(parameters, np.arange(len(parameters)) >= len(parameters) - held_out)


def _single_actions(inputs: InputTable) -> list[FloatArray]:
    """Each parameter at 1; then groups of both sides at 1 and 1/2; then two-way pose weights at -1."""
    identity = np.eye(len(inputs.parameters))
    groups = [identity[group].sum(axis=0) for group in _groups(inputs)]
    backwards = list(-identity[inputs.parameter_lower < 0.0])
    paired = [group for group in groups if group.sum() > 1.0]
    return [*identity, *paired, *(0.5 * group for group in groups), *backwards]


def _groups(inputs: InputTable) -> list[list[int]]:
    """Positions of the parameters that belong together: both sides of a muscle or lid; each jaw weight alone."""
    groups: dict[str, list[int]] = {}
    for position, name in enumerate(inputs.parameters):
        groups.setdefault(without_side(name), []).append(position)
    return list(groups.values())


def _combination(inputs: InputTable, key: tuple[int, ...]) -> FloatArray:
    rng = np.random.default_rng(key)
    result = np.zeros(len(inputs.parameters))
    muscles = [group for group in _groups(inputs) if group[0] < len(inputs.muscles)]
    wanted = min(int(rng.integers(1, LARGEST_COMBINATION + 1)), len(muscles))
    for index in rng.choice(len(muscles), wanted, replace=False):
        _activate(result, muscles[index], rng)
    position = {name: number for number, name in enumerate(inputs.parameters)}
    if position.keys() >= set(JawMotion.inputs) and rng.uniform() < WITH_JAW:
        opening, forward, sideways = (position[name] for name in JawMotion.inputs)
        result[opening] = rng.uniform(0.05, 1.0)
        if rng.uniform() < 0.5:
            result[forward], result[sideways] = rng.uniform(-1.0, 1.0, 2)
    if position.keys() >= set(LidMotion.inputs) and rng.uniform() < WITH_LIDS:
        left, right = rng.uniform(-1.0, 1.0, 2)
        together = rng.uniform() < SYMMETRIC
        for name, weight in zip(LidMotion.inputs, (left, left if together else right), strict=True):
            result[position[name]] = weight
    return result


def _activate(result: FloatArray, group: list[int], rng: np.random.Generator) -> None:
    weight, kind = rng.uniform(0.1, 1.0), rng.uniform()
    if len(group) == 1 or kind < SYMMETRIC:
        result[group] = weight
    elif kind < SYMMETRIC + ONE_SIDED:
        result[group[int(rng.integers(len(group)))]] = weight
    else:
        result[group] = rng.uniform(0.0, 1.0, len(group))
