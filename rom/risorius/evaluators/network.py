"""The learned map of contact: a small committee of neural networks on activations that compete.

Each member bends combinations of the competing variables b (`competition`), then combinations of these and of what it
has bent, and adds up. What is combined are even and odd parts, x+ and x-: the sum and the difference of what x is for
the face and for its mirror image, so that x = (x+ + x-) / 2. With phi(z) = sqrt(z^2 + WIDTH^2) - WIDTH,

    z+- = W' b+-              h = phi(z + c) - phi(c)
    z+- = V+-' (b, h)+-       k = phi(z + d) - phi(d)
    q+- = A+-' (b, h, k)+-,

which is exact at rest; q+ are the symmetric modes of a symmetric face, q- the others. The answer is the mean of the
members, and how far they are apart tells what they know of their error (Krogh and Vedelsby 1995). `network_fit` trains
them; what they miss at usual inputs, `remainder` adds.

What an answer takes is the time to multiply by all weights, so they are whole numbers of eight bits (`paired_sums`).
Parameters that are their own mirror image, or a face without one, have no odd part, and need none of its weights.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import h5py
import numba
import numpy as np
import numpy.typing as npt

from risorius.evaluators.competition import compete
from risorius.evaluators.observations import Observations, Reflection
from risorius.evaluators.remainder import Remainder
from risorius.evaluators.setting import Setting
from risorius.evaluators.whole_weights import WholeWeights
from risorius.jaw import FloatArray
from risorius.paired_sums import combine, in_numbers, in_pairs
from risorius.part import Part
from risorius.vector_sums import whole_blocks
from risorius.whole_steps import Single

WIDTH = 0.02  # of a bend's rounded corner
COMBINED = ("first", "second_even", "second_odd", "even", "odd")  # fields of a member with weights


@dataclass(frozen=True)
class Member:
    """competition (p, p); first (p, h), second (p + h, h) combinations with thresholds (h,) each.

    even (p + 2 h, e), odd (p + 2 h, o): coordinates of the symmetric and of the other modes, in their order.
    """

    competition: FloatArray
    first: WholeWeights
    first_thresholds: Single
    second_even: WholeWeights
    second_odd: WholeWeights
    second_thresholds: Single
    even: WholeWeights
    odd: WholeWeights

    @classmethod
    def of(cls, competition: FloatArray, **values: Single) -> Member:
        """Round what is combined, of the values of all fields."""
        fields: dict[str, Any] = {**values, **{name: WholeWeights.of(values[name]) for name in COMBINED}}
        return cls(competition, **fields)

    def only(self, even: npt.NDArray[np.int64], odd: npt.NDArray[np.int64]) -> Member:
        """Return that of some modes of either kind, by their positions."""
        return replace(self, even=self.even.columns(even), odd=self.odd.columns(odd))

    def of_parameters(self, which: npt.NDArray[np.int64]) -> Member:
        """Return that of some parameters, the others of which are always 0: so is what they put into any sum."""
        count = len(self.competition)
        competition = np.ascontiguousarray(self.competition[np.ix_(which, which)])

        def left(weights: WholeWeights) -> WholeWeights:
            return weights.rows(np.concatenate([which, np.arange(count, len(weights.numbers))]))

        weights: dict[str, Any] = {name: left(getattr(self, name)) for name in COMBINED}
        return replace(self, competition=competition, **weights)

    def write(self, group: h5py.Group) -> None:
        """Store all fields."""
        for name, value in vars(self).items():
            if name in COMBINED:
                value.write(group.create_group(name))
            else:
                group[name] = value

    @classmethod
    def read(cls, group: h5py.Group) -> Member:
        """Load what `write` stored."""
        fields: dict[str, Any] = {name: WholeWeights.read(group[name]) for name in COMBINED}
        fields |= {name: group[name][()] for name in cls.__dataclass_fields__ if name not in COMBINED}
        return cls(**fields)


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
    def _tables(self) -> tuple[npt.NDArray[np.generic], ...]:
        """Fields of the members, one after the other, in the order of `Member`; what is combined is in pairs, and
        followed by its steps. Modes in the order of the members' answers.
        """
        tables: list[npt.NDArray[np.generic]] = []
        for name in Member.__dataclass_fields__:
            fields = [getattr(one, name) for one in self.members]
            if name in COMBINED:
                tables += [np.stack([in_pairs(one.numbers) for one in fields]), np.stack([one.steps for one in fields])]
            else:
                tables.append(np.stack(fields))
        return *tables, np.concatenate(self._modes)

    @cached_property
    def _work(self) -> tuple[npt.NDArray[np.generic], ...]:
        """Parameters, b; parts of the features, one of them in numbers; sums of numbers; combinations; answers of the
        members.
        """
        count, width = self.members[0].first.numbers.shape
        modes, features = len(self.reflection.parity), count + 2 * width
        room = max(whole_blocks(width), whole_blocks(modes))
        shapes = ((2, features), (2, room), (len(self.members), modes))
        parts, combined, answers = (np.empty(shape, np.float32) for shape in shapes)
        numbers, sums = np.empty(features + 1, np.int16), np.empty(room, np.int32)
        return np.zeros(count), np.empty(count), parts, numbers, sums, combined, answers

    def coordinates(self, parameters: FloatArray, out: FloatArray) -> None:
        """Write the modal coordinates (r,) of parameters (p,) into `out`."""
        everything, *work = self._work
        everything[self.inputs] = parameters
        partner, sign = self.reflection.partner, self.reflection.sign
        self.doubt = _evaluate(everything, partner, sign, *self._tables, *work, out)
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
        members = tuple(member.of_parameters(kept) for member in left.members)
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
    parameters, partner, sign,
    competition, first, first_steps, thresholds, second_even, second_even_steps, second_odd, second_odd_steps,
    second_thresholds, even, even_steps, odd, odd_steps, modes,
    variables, features, numbers, sums, combined, answers, out,
):  # fmt: skip
    """Write the mean answer of all members into `out` (r,); return how far they are apart."""
    count, neurons, split = len(variables), thresholds.shape[1], even_steps.shape[1]
    middle, parts = count + neurons, 1
    for i in range(count):
        if parameters[i] != sign[i] * parameters[partner[i]]:
            parts = 2
    for k in range(len(answers)):
        compete(parameters, competition[k], variables)
        for i in range(count):
            ours, image = np.float32(variables[i]), np.float32(sign[i] * variables[partner[i]])
            features[0, i], features[1, i] = ours + image, ours - image
        for part in range(parts):
            _combine(first[k], first_steps[k], features[part, :count], numbers, sums, combined[part])
        _bend(combined, thresholds[k], parts, count, features)
        _combine(second_even[k], second_even_steps[k], features[0, :middle], numbers, sums, combined[0])
        if parts == 2:
            _combine(second_odd[k], second_odd_steps[k], features[1, :middle], numbers, sums, combined[1])
        _bend(combined, second_thresholds[k], parts, middle, features)
        _combine(even[k], even_steps[k], features[0], numbers, sums, answers[k, :split])
        answers[k, split:] = 0.0
        if parts == 2:
            _combine(odd[k], odd_steps[k], features[1], numbers, sums, answers[k, split:])
    return _mean(answers, modes, combined[0], out)


@numba.njit(cache=True)
def _combine(weights, steps, features, numbers, sums, out):  # type: ignore[no-untyped-def]
    """Write sums (m,) of features (n,) times weights."""
    count = len(features) + len(features) % 2
    step = in_numbers(features, numbers[:count])
    combine(weights, numbers[:count], sums[: len(weights) // count])
    for r in range(len(steps)):
        out[r] = sums[r] * (step * steps[r])


@numba.njit(cache=True)
def _bend(combined, thresholds, parts, start, features):  # type: ignore[no-untyped-def]
    """Write the parts of bent combinations (2, h) into features from `start` on; of an odd one that is 0 nothing."""
    square, half, two = np.float32(WIDTH * WIDTH), np.float32(0.5), np.float32(2.0)
    count = len(thresholds)
    even, odd = features[0, start : start + count], features[1, start : start + count]  # or loops stay scalar
    if parts == 1:
        for r in range(count):
            z = half * combined[0, r] + thresholds[r]
            even[r] = two * (np.sqrt(z * z + square) - np.sqrt(thresholds[r] * thresholds[r] + square))
        return
    for r in range(count):
        z, beside = half * combined[0, r] + thresholds[r], half * combined[1, r]
        ours, image = z + beside, z - beside
        ours, image = np.sqrt(ours * ours + square), np.sqrt(image * image + square)
        at_rest = np.sqrt(thresholds[r] * thresholds[r] + square)
        even[r] = ours - at_rest + (image - at_rest)
        odd[r] = ours - image


@numba.njit(cache=True, fastmath={"contract", "reassoc"})
def _mean(answers, modes, mean, out):  # type: ignore[no-untyped-def]
    """Write the mean of answers (k, r), in the order of `modes` (r,); return the root mean square distance to it."""
    count, square = np.float32(len(answers)), np.float32(0.0)
    mean[:] = 0.0
    for k in range(len(answers)):
        for r in range(len(modes)):
            mean[r] += answers[k, r] / count
    for k in range(len(answers)):
        for r in range(len(modes)):
            square += (answers[k, r] - mean[r]) ** 2
    for r in range(len(modes)):
        out[modes[r]] = mean[r]
    return (square / count) ** 0.5
