"""Combinations of actions from low-discrepancy points: one construction for each part of the design.

The coordinates of a point in [0, 1) say, in this order: how many actions; of each muscle action how early it is taken,
its weight, on which side, and the weight of the other side; of each pose whether it is taken, its weight, on which side
and the weight of the other side.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.stats import qmc

from risorius.jaw import FloatArray
from risorius_offline.sampling.actions import Action, Actions

LARGEST_COMBINATION = 4
SYMMETRIC, ONE_SIDED = 0.6, 0.2  # the rest has a weight of its own on either side
WITH_POSE, MAINLY_POSES = 0.3, 0.7  # of each pose
WEAK, STRONG = 0.1, 0.6  # least weights of an ordinary and of a strong action
FEWEST_STRONG = 5


@dataclass(frozen=True)
class Point:
    """A low-discrepancy point, its coordinates by meaning; for muscles and poses the second axis is the action."""

    size: float
    muscles: FloatArray
    poses: FloatArray

    def ranked(self) -> list[int]:
        """Muscle actions in the order in which they are taken."""
        return [int(k) for k in np.argsort(self.muscles[0], kind="stable")]


def points(actions: Actions, count: int, key: tuple[int, ...]) -> list[Point]:
    """Return the first points of the scrambled Sobol sequence (Owen 1998) of a key."""
    muscles, poses = len(actions.muscles), len(actions.poses)
    sequence = qmc.Sobol(1 + 4 * (muscles + poses), seed=np.random.default_rng(key))
    drawn = sequence.random_base2(max(0, count - 1).bit_length())[:count]
    split = 1 + 4 * muscles
    return [Point(float(u[0]), u[1:split].reshape(4, muscles), u[split:].reshape(4, poses)) for u in drawn]


def ordinary(actions: Actions, point: Point) -> FloatArray:
    """Up to four muscle actions, most of them symmetric, and perhaps a pose."""
    taken = point.ranked()[: 1 + int(point.size * LARGEST_COMBINATION)]
    return _muscles(actions, point, taken, WEAK) + _poses(actions, point, WITH_POSE, 0 if actions.muscles else 1)


def asymmetric(actions: Actions, point: Point) -> FloatArray:
    """Up to three muscle actions, on one side each or with a weight of its own on either; ordinary without muscles."""
    if not actions.muscles:
        return ordinary(actions, point)
    taken = point.ranked()[: 1 + int(point.size * (LARGEST_COMBINATION - 1))]
    sides = point.muscles.copy()
    sides[2] = SYMMETRIC + (1.0 - SYMMETRIC) * sides[2]
    return _muscles(actions, Point(point.size, sides, point.poses), taken, WEAK)


def opposing(actions: Actions, point: Point) -> FloatArray:
    """A pair of opponents; without any in the face, an ordinary combination."""
    if not actions.opponents:
        return ordinary(actions, point)
    pair = actions.opponents[int(point.size * len(actions.opponents))]
    return _muscles(actions, point, list(pair), WEAK)


def strong(actions: Actions, point: Point) -> FloatArray:
    """Five to all muscle actions at weights from 0.6 on, and perhaps a pose."""
    fewest = min(FEWEST_STRONG, len(actions.muscles))
    taken = point.ranked()[: fewest + int(point.size * (len(actions.muscles) - fewest + 1))]
    return _muscles(actions, point, taken, STRONG) + _poses(actions, point, WITH_POSE, 0 if actions.muscles else 1)


def posed(actions: Actions, point: Point) -> FloatArray:
    """Poses, and in half of the cases one muscle action; without poses, an ordinary combination."""
    if not actions.poses:
        return ordinary(actions, point)
    return _muscles(actions, point, point.ranked()[: round(point.size)], WEAK) + _poses(actions, point, MAINLY_POSES, 1)


KINDS: Mapping[str, Callable[[Actions, Point], FloatArray]] = {
    "ordinary": ordinary,
    "asymmetric": asymmetric,
    "opposing": opposing,
    "strong": strong,
    "posed": posed,
}


def _muscles(actions: Actions, point: Point, taken: list[int], least: float) -> FloatArray:
    result = np.zeros(actions.count)
    for k in taken:
        _, weight, side, other = point.muscles[:, k]
        _activate(result, actions.muscles[k], (least, 1.0), weight, side, other)
    return result


def _poses(actions: Actions, point: Point, share: float, fewest: int) -> FloatArray:
    """A share of the poses, but `fewest` at least."""
    result = np.zeros(actions.count)
    rank = np.argsort(np.argsort(point.poses[0], kind="stable"))
    for k, action in enumerate(actions.poses):
        taken, weight, side, other = point.poses[:, k]
        if taken < share or rank[k] < fewest:
            _activate(result, action, (action.lower, 1.0), weight, side, other)
    return result


def _activate(
    result: FloatArray, action: Action, limits: tuple[float, float], weight: float, side: float, other: float
) -> None:
    lower, upper = limits
    first, second = lower + (upper - lower) * weight, lower + (upper - lower) * other
    positions = list(action.positions)
    if len(positions) == 1 or side < SYMMETRIC:
        result[positions] = first
    elif side < SYMMETRIC + ONE_SIDED:
        result[positions[int(side < SYMMETRIC + 0.5 * ONE_SIDED)]] = first
    else:
        result[positions] = first, second
