"""The learned map of contact: a small committee of neural networks on activations that compete.

Each member bends combinations of the competing variables b (`competition`), then combinations of these and of what it
has bent, and adds up: with phi(z) = sqrt(z^2 + WIDTH^2) - WIDTH,

    h = phi(W' b + c) - phi(c),    k = phi(V' (b, h, h of the mirror image) + d) - phi(d),    q = A' (b, h, k),

which is exact at rest. On a symmetric face the sum of (b, h, k) and those of the mirror image drives the symmetric
modes, their difference the others. The answer is the mean of the members, and how far they are apart tells what they
know of their error (Krogh and Vedelsby 1995). `network_fit` trains them; what they miss at
usual inputs, `remainder` adds.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import h5py
import numba
import numpy as np
import numpy.typing as npt

from risorius.evaluators.competition import compete
from risorius.evaluators.observations import Observations, Reflection
from risorius.evaluators.remainder import Remainder
from risorius.evaluators.setting import Setting
from risorius.jaw import FloatArray
from risorius.packed_fields import in_blocks, whole_blocks
from risorius.part import Part
from risorius.vector_sums import combine

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

    def of(self, parameters: npt.NDArray[np.int64]) -> Member:
        """Return that of some parameters, the others of which are always 0: so is what they put into any sum."""
        features = np.concatenate([parameters, np.arange(len(self.first), len(self.second))])
        return replace(
            self,
            competition=np.ascontiguousarray(self.competition[np.ix_(parameters, parameters)]),
            first=self.first[parameters],
            second=self.second[features],
            even=self.even[features],
            odd=self.odd[features],
        )

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
    the parameters are given, the others are 0; remainder: what the members miss, None where that was not learned. Not
    thread-safe.

    doubt: root mean square distance of the members' answers to their mean.
    """

    members: tuple[Member, ...]
    reflection: Reflection
    inputs: npt.NDArray[np.int64]
    remainder: Remainder | None = None
    doubt: float = field(default=0.0, init=False)
    name = "network"

    @cached_property
    def _modes(self) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
        """Positions of symmetric modes and of the others."""
        return np.flatnonzero(self.reflection.parity > 0.0), np.flatnonzero(self.reflection.parity <= 0.0)

    @cached_property
    def _tables(self) -> tuple[FloatArray, Single, Single, Single, Single, Single, Single]:
        """Fields of the members, one after the other, in the order of `Member`; what is combined is in blocks."""
        members = self.members
        return (
            np.stack([one.competition for one in members]),
            np.stack([in_blocks(one.first) for one in members]),
            np.stack([one.first_thresholds for one in members]),
            np.stack([in_blocks(one.second) for one in members]),
            np.stack([one.second_thresholds for one in members]),
            np.stack([in_blocks(one.even) for one in members]),
            np.stack([in_blocks(one.odd) for one in members]),
        )

    @cached_property
    def _work(self) -> tuple[FloatArray, FloatArray, Single, Single, Single, Single]:
        """Parameters, b, features of both sides, what is combined, what comes of it, answers of the members."""
        count, width = self.members[0].first.shape
        modes = len(self.reflection.parity)
        return (
            np.zeros(count),
            np.empty(count),
            np.zeros((2, count + 2 * width), np.float32),
            np.empty(count + 2 * width, np.float32),
            np.empty(max(whole_blocks(modes), whole_blocks(width)), np.float32),
            np.empty((len(self.members), modes), np.float32),
        )

    def coordinates(self, parameters: FloatArray, out: FloatArray) -> None:
        """Write the modal coordinates (r,) of parameters (p,) into `out`."""
        everything, *work = self._work
        everything[self.inputs] = parameters
        partner, sign = self.reflection.partner, self.reflection.sign
        self.doubt = _evaluate(everything, partner, sign, *self._tables, *self._modes, *work, out)
        if self.remainder is not None:
            self.remainder.add(parameters, out)

    def completed(self, observations: Observations) -> NetworkMap:
        """Return the map that adds what this one misses at observations."""
        answers = np.empty_like(observations.coordinates)
        for parameters, answer in zip(observations.parameters, answers, strict=True):
            self.coordinates(parameters, answer)
        return replace(self, remainder=Remainder.fit(observations, observations.coordinates - answers))

    def at(self, setting: Setting) -> NetworkMap:
        """Return that of the leading modes."""
        return self._only(np.arange(setting.rank), np.arange(len(self.inputs)))

    def within(self, part: Part) -> NetworkMap:
        """Return that of the parameters and modes of a part; of other parameters only mirror images are left."""
        left, partner = self._only(part.modes, part.parameters), self.reflection.partner
        kept = np.union1d(left.inputs, partner[left.inputs])
        reflection = Reflection(
            np.searchsorted(kept, partner[kept]), self.reflection.sign[kept], left.reflection.parity
        )
        members = tuple(member.of(kept) for member in left.members)
        return NetworkMap(members, reflection, np.searchsorted(kept, left.inputs), left.remainder)

    def _only(self, modes: npt.NDArray[np.int64], parameters: npt.NDArray[np.int64]) -> NetworkMap:
        even, odd = (np.flatnonzero(np.isin(numbers, modes)) for numbers in self._modes)
        reflection = replace(self.reflection, parity=self.reflection.parity[modes])
        members = tuple(member.only(even, odd) for member in self.members)
        remainder = None if self.remainder is None else self.remainder.only(modes, parameters)
        return NetworkMap(members, reflection, self.inputs[parameters], remainder)

    def write(self, group: h5py.Group) -> None:
        """Store members, inputs, reflection and remainder."""
        group["inputs"] = self.inputs
        for name, value in vars(self.reflection).items():
            group[f"reflection/{name}"] = value
        for number, member in enumerate(self.members):
            member.write(group.create_group(f"members/{number}"))
        if self.remainder is not None:
            self.remainder.write(group.create_group("remainder"))

    @classmethod
    def read(cls, group: h5py.Group) -> NetworkMap:
        """Load what `write` stored."""
        reflection = Reflection(*(group[f"reflection/{name}"][()] for name in ("partner", "sign", "parity")))
        members = tuple(Member.read(group[f"members/{number}"]) for number in range(len(group["members"])))
        remainder = Remainder.read(group["remainder"]) if "remainder" in group else None
        return cls(members, reflection, group["inputs"][()], remainder)


@numba.njit(cache=True)
def _evaluate(  # type: ignore[no-untyped-def]
    parameters, partner, sign, competition, first, thresholds, second, second_thresholds, even, odd,
    even_modes, odd_modes, variables, features, inputs, sums, answers, out,
):  # fmt: skip
    """Write the mean answer of all members into `out` (r,); return how far they are apart."""
    for k in range(len(answers)):
        compete(parameters, competition[k], variables)
        _features(
            variables, partner, sign, first[k], thresholds[k], second[k], second_thresholds[k], features, inputs, sums
        )
        _add_up(features, 1.0, even[k], even_modes, inputs, sums, answers[k])
        _add_up(features, -1.0, odd[k], odd_modes, inputs, sums, answers[k])
    return _mean(answers, out)


@numba.njit(cache=True)
def _features(variables, partner, sign, first, thresholds, second, second_thresholds, out, inputs, sums):  # type: ignore[no-untyped-def]
    """Write the features (2, p + 2 h) of variables (p,) and of their mirror image."""
    count = len(variables)
    middle = count + len(thresholds)
    symmetric = True
    for i in range(count):
        out[0, i], out[1, i] = variables[i], sign[i] * variables[partner[i]]
        symmetric &= out[0, i] == out[1, i]
    sides = 1 if symmetric else 2
    for side in range(sides):
        _bend(first, out[side, :count], thresholds, sums, out[side, count:middle])
    if symmetric:
        out[1, count:middle] = out[0, count:middle]
    for side in range(sides):
        inputs[:middle] = out[side, :middle]
        inputs[middle:] = out[1 - side, count:middle]
        _bend(second, inputs, second_thresholds, sums, out[side, middle:])
    if symmetric:
        out[1, middle:] = out[0, middle:]


@numba.njit(cache=True)
def _bend(weights, inputs, thresholds, sums, out):  # type: ignore[no-untyped-def]
    """Write the bent combinations (h,) of inputs, 0 where these are."""
    square = np.float32(WIDTH * WIDTH)
    combine(weights, inputs, sums[: len(weights) // len(inputs)])
    for r in range(len(out)):
        z = sums[r] + thresholds[r]
        out[r] = np.sqrt(z * z + square) - np.sqrt(thresholds[r] * thresholds[r] + square)


@numba.njit(cache=True)
def _add_up(features, sign, coefficients, modes, inputs, sums, out):  # type: ignore[no-untyped-def]
    """Write the coordinates of some modes into their places in `out`."""
    for i in range(len(inputs)):
        inputs[i] = features[0, i] + sign * features[1, i]
    combine(coefficients, inputs, sums[: len(coefficients) // len(inputs)])
    for r in range(len(modes)):
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
