"""The learned map of contact: a small committee of neural networks on activations that compete.

Each member bends combinations of the competing variables b (`competition`), then combinations of these and of what it
has bent, and adds up: with phi(z) = sqrt(z^2 + WIDTH^2) - WIDTH,

    h = phi(W' b + c) - phi(c),    k = phi(V' (b, h, h of the mirror image) + d) - phi(d),    q = A' (b, h, k),

which is exact at rest. On a symmetric face the sum of (b, h, k) and those of the mirror image drives the symmetric
modes, their difference the others. The answer is the mean of the members, and how far they are apart tells what they
know of their error (Krogh and Vedelsby 1995). `network_fit` trains them.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import h5py
import numba
import numpy as np
import numpy.typing as npt

from risorius.evaluators.competition import compete
from risorius.evaluators.observations import Reflection
from risorius.evaluators.row_sums import add_rows
from risorius.evaluators.setting import Setting
from risorius.jaw import FloatArray
from risorius.part import Part

Single = npt.NDArray[np.float32]
WIDTH = 0.02  # of a bend's rounded corner


@dataclass(frozen=True)
class Member:
    """competition (p, p); first (p, h), second (p + 2 h, h) combinations with thresholds (h,) each.

    even (p + 2 h, e), odd (p + 2 h, o): coordinates of the symmetric and of the other modes, in their order, per unit
    of the sum and of the difference of features.
    """

    competition: FloatArray
    first: Single
    first_thresholds: Single
    second: Single
    second_thresholds: Single
    even: Single
    odd: Single

    def only(self, even: npt.NDArray[np.int64], odd: npt.NDArray[np.int64]) -> Member:
        """Return that of some modes of either kind, by their positions."""
        return replace(self, even=np.ascontiguousarray(self.even[:, even]), odd=np.ascontiguousarray(self.odd[:, odd]))

    def write(self, group: h5py.Group) -> None:
        """Store all fields."""
        for name, value in vars(self).items():
            group[name] = value

    @classmethod
    def read(cls, group: h5py.Group) -> Member:
        """Load what `write` stored."""
        return cls(**{name: group[name][()] for name in cls.__dataclass_fields__})


@dataclass
class NetworkMap:
    """members: of the same sizes; reflection: of all parameters and of the modes that are left; inputs (k,): which of
    the parameters are given, the others are 0. Not thread-safe.

    doubt: root mean square distance of the members' answers to their mean.
    """

    members: tuple[Member, ...]
    reflection: Reflection
    inputs: npt.NDArray[np.int64]
    doubt: float = field(default=0.0, init=False)
    name = "network"

    @cached_property
    def _modes(self) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
        """Positions of symmetric modes and of the others."""
        return np.flatnonzero(self.reflection.parity > 0.0), np.flatnonzero(self.reflection.parity <= 0.0)

    @cached_property
    def _work(self) -> tuple[FloatArray, FloatArray, Single, FloatArray, npt.NDArray[np.int64], Single, Single]:
        """Parameters, b, features of both sides, of which those that are not 0 and where, coordinates, answers."""
        count, features = len(self.reflection.partner), len(self.members[0].even)
        inputs = len(self.members[0].second)
        modes = len(self.reflection.parity)
        return (
            np.zeros(count),
            np.empty(count),
            np.zeros((2, features), np.float32),
            np.empty(max(features, inputs)),
            np.empty(max(features, inputs), np.int64),
            np.empty(modes, np.float32),
            np.empty((len(self.members), modes), np.float32),
        )

    def coordinates(self, parameters: FloatArray, out: FloatArray) -> None:
        """Write the modal coordinates (r,) of parameters (p,) into `out`."""
        everything, variables, features, active, positions, sums, answers = self._work
        everything[self.inputs] = parameters
        partner, sign = self.reflection.partner, self.reflection.sign
        even, odd = self._modes
        for member, answer in zip(self.members, answers, strict=True):
            compete(everything, member.competition, variables)
            _features(
                variables, partner, sign, member.first, member.first_thresholds, member.second,
                member.second_thresholds, features, active, positions,
            )  # fmt: skip
            _add_up(features, 1.0, member.even, even, active, positions, sums, answer)
            _add_up(features, -1.0, member.odd, odd, active, positions, sums, answer)
        self.doubt = _mean(answers, out)

    def at(self, setting: Setting) -> NetworkMap:
        """Return that of the leading modes."""
        return self._only(np.arange(setting.rank), self.inputs)

    def within(self, part: Part) -> NetworkMap:
        """Return that of the parameters and modes of a part."""
        return self._only(part.modes, self.inputs[part.parameters])

    def _only(self, modes: npt.NDArray[np.int64], inputs: npt.NDArray[np.int64]) -> NetworkMap:
        even, odd = (np.flatnonzero(np.isin(numbers, modes)) for numbers in self._modes)
        reflection = replace(self.reflection, parity=self.reflection.parity[modes])
        return NetworkMap(tuple(member.only(even, odd) for member in self.members), reflection, inputs)

    def write(self, group: h5py.Group) -> None:
        """Store members, inputs and reflection."""
        group["inputs"] = self.inputs
        for name, value in vars(self.reflection).items():
            group[f"reflection/{name}"] = value
        for number, member in enumerate(self.members):
            member.write(group.create_group(f"members/{number}"))

    @classmethod
    def read(cls, group: h5py.Group) -> NetworkMap:
        """Load what `write` stored."""
        reflection = Reflection(*(group[f"reflection/{name}"][()] for name in ("partner", "sign", "parity")))
        members = tuple(Member.read(group[f"members/{number}"]) for number in range(len(group["members"])))
        return cls(members, reflection, group["inputs"][()])


@numba.njit(cache=True)
def _features(variables, partner, sign, first, thresholds, second, second_thresholds, out, active, positions):  # type: ignore[no-untyped-def]
    """Write the features (2, p + 2 h) of variables (p,) and of their mirror image."""
    count, width = first.shape
    middle = count + width
    symmetric = True
    for i in range(count):
        out[0, i], out[1, i] = variables[i], sign[i] * variables[partner[i]]
        symmetric &= out[0, i] == out[1, i]
    sides = 1 if symmetric else 2
    for side in range(sides):
        found = _list_active(out[side, :count], 0, 0, active, positions)
        _bend_rows(active, positions, found, first, thresholds, out[side, count:middle])
    if symmetric:
        out[1, count:middle] = out[0, count:middle]
    for side in range(sides):
        found = _list_active(out[side, :middle], 0, 0, active, positions)
        found = _list_active(out[1 - side, count:middle], middle, found, active, positions)
        _bend_rows(active, positions, found, second, second_thresholds, out[side, middle:])
    if symmetric:
        out[1, middle:] = out[0, middle:]


@numba.njit(cache=True)
def _list_active(values, first, count, active, positions):  # type: ignore[no-untyped-def]
    """List values that are not 0, and their numbers from `first` on, behind the `count` listed; return how many."""
    for i in range(len(values)):
        active[count], positions[count] = values[i], first + i
        count += values[i] != 0.0
    return count


@numba.njit(cache=True)
def _bend_rows(active, positions, count, weights, thresholds, out):  # type: ignore[no-untyped-def]
    """Write the bent combinations (h,) of active values, 0 where these are."""
    square = np.float32(WIDTH * WIDTH)
    out[:] = thresholds
    add_rows(active, positions, count, weights, out)
    for r in range(len(out)):
        out[r] = np.sqrt(out[r] * out[r] + square) - np.sqrt(thresholds[r] * thresholds[r] + square)


@numba.njit(cache=True)
def _add_up(features, sign, coefficients, modes, active, positions, sums, out):  # type: ignore[no-untyped-def]
    """Write the coordinates of some modes into their places in `out`."""
    count = 0
    for i in range(features.shape[1]):
        value = features[0, i] + sign * features[1, i]
        active[count], positions[count] = value, i
        count += value != 0.0
    width = len(modes)
    sums[:width] = 0.0
    add_rows(active, positions, count, coefficients, sums)
    for r in range(width):
        out[modes[r]] = sums[r]


@numba.njit(cache=True)
def _mean(answers, out):  # type: ignore[no-untyped-def]
    """Write the mean (r,) of answers (k, r); return the root mean square distance of these to it."""
    count, square = len(answers), 0.0
    for r in range(len(out)):
        total = 0.0
        for k in range(count):
            total += answers[k, r]
        out[r] = total / count
        for k in range(count):
            square += (answers[k, r] - out[r]) ** 2
    return (square / count) ** 0.5
