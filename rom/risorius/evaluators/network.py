"""The learned map of contact: a small committee of neural networks on activations that compete.

Each member bends combinations of the competing variables b (`competition`), then combinations of these and of what it
has bent, and adds up: with phi(z) = sqrt(z^2 + WIDTH^2) - WIDTH,

    h = phi(W' b + c) - phi(c),    k = phi(V' (b, h, h of the mirror image) + d) - phi(d),    q = A' (b, h, k),

which is exact at rest. On a symmetric face the sum of (b, h, k) and those of the mirror image drives the symmetric
modes, their difference the others. The answer is the mean of the members, and how far they are apart tells what they
know of their error (Krogh and Vedelsby 1995). `network_fit` trains them; what they miss at
usual inputs, `remainder` adds.

What an answer takes is the time to read all weights, so they are 16-bit integers (`in_steps`), and read once for both
sides. Parameters that are their own mirror image, or a face without one, take half of that.
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
from risorius.whole_steps import Single, in_steps, rounded

WIDTH = 0.02  # of a bend's rounded corner
COMBINED = ("first", "second", "even", "odd")  # fields of a member with weights


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

    def rounded(self) -> Member:
        """Return that with the weights that its evaluation uses."""
        first, second, even, odd = (rounded(getattr(self, name)) for name in COMBINED)
        return replace(self, first=first, second=second, even=even, odd=odd)

    def write(self, group: h5py.Group) -> None:
        """Store all fields."""
        for name, value in vars(self).items():
            group[name] = value

    @classmethod
    def read(cls, group: h5py.Group) -> Member:
        """Load what `write` stored."""
        return cls(**{name: group[name][()] for name in cls.__dataclass_fields__}).rounded()


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
        """Fields of the members, one after the other, in the order of `Member`; what is combined is in blocks, and
        followed by its steps. Modes in the order of the members' answers.
        """
        tables: list[npt.NDArray[np.generic]] = []
        for name in Member.__dataclass_fields__:
            fields = [getattr(one, name) for one in self.members]
            if name in COMBINED:
                numbers, steps = zip(*(in_steps(one) for one in fields), strict=True)
                tables += [np.stack([in_blocks(one) for one in numbers]), np.stack(steps)]
            else:
                tables.append(np.stack(fields))
        return *tables, np.concatenate(self._modes)

    @cached_property
    def _work(self) -> tuple[FloatArray | Single, ...]:
        """Parameters, b; of both sides: b, what the second layer combines, features, bends; sum and difference of both
        sides' features; what is made of either; answers of the members.
        """
        count, width = self.members[0].first.shape
        modes, features = len(self.reflection.parity), count + 2 * width
        both = ((2, count), (2, features), (2, features), (2, whole_blocks(width)), (2, features))
        shapes = (*both, (whole_blocks(modes),), (len(self.members), modes))
        return np.zeros(count), np.empty(count), *(np.empty(shape, np.float32) for shape in shapes)

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
    parameters, partner, sign,
    competition, first, first_steps, thresholds, second, second_steps, second_thresholds, even, even_steps, odd,
    odd_steps, modes, variables, entry, inputs, features, bent, combined, sums, answers, out,
):  # fmt: skip
    """Write the mean answer of all members into `out` (r,); return how far they are apart.

    Of parameters that are their own mirror image both sides' features are the same: one side is enough.
    """
    count, neurons, split = len(variables), thresholds.shape[1], even_steps.shape[1]
    middle, sides = count + neurons, 1
    for i in range(count):
        if parameters[i] != sign[i] * parameters[partner[i]]:
            sides = 2
    for k in range(len(answers)):
        compete(parameters, competition[k], variables)
        for i in range(count):
            entry[0, i], entry[1, i] = variables[i], sign[i] * variables[partner[i]]
        _bend(first[k], first_steps[k], thresholds[k], entry, sides, bent)
        for side in range(sides):
            for i in range(count):
                features[side, i] = inputs[side, i] = entry[side, i]
            for i in range(neurons):
                features[side, count + i] = inputs[side, count + i] = bent[side, i]
                inputs[side, middle + i] = bent[sides - 1 - side, i]
        _bend(second[k], second_steps[k], second_thresholds[k], inputs, sides, bent)
        for side in range(sides):
            for i in range(neurons):
                features[side, middle + i] = bent[side, i]
        for i in range(features.shape[1]):
            combined[0, i] = features[0, i] + features[sides - 1, i]
            combined[1, i] = features[0, i] - features[sides - 1, i]
        _add_up(even[k], even_steps[k], combined[0], sums, answers[k, :split])
        if sides == 2:
            _add_up(odd[k], odd_steps[k], combined[1], sums, answers[k, split:])
        else:
            answers[k, split:] = 0.0
    return _mean(answers, modes, sums, out)


@numba.njit(cache=True)
def _bend(weights, steps, thresholds, inputs, sides, out):  # type: ignore[no-untyped-def]
    """Write the bent combinations (h,) of inputs of the first or of both sides, 0 where these are."""
    square = np.float32(WIDTH * WIDTH)
    if sides == 1:
        combine(weights, inputs[0], out[0])
    else:
        combine(weights, inputs, out)
    for side in range(sides):
        for r in range(len(thresholds)):
            z = out[side, r] * steps[r] + thresholds[r]
            out[side, r] = np.sqrt(z * z + square) - np.sqrt(thresholds[r] * thresholds[r] + square)


@numba.njit(cache=True)
def _add_up(weights, steps, features, sums, out):  # type: ignore[no-untyped-def]
    """Write the coordinates of modes of one kind."""
    combine(weights, features, sums[: len(weights) // len(features)])
    for r in range(len(out)):
        out[r] = sums[r] * steps[r]


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
