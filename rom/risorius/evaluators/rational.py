"""The learned map: products of activations that saturate in competition, and kinks of their combinations.

It is fitted to snapshots and their derivatives. Terms are products first, then kinks. On a symmetric face the sum of a
term and its mirror image drives the symmetric modes, their difference the others: half the work of one map for all
modes, and half of that again where the input is symmetric.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import h5py
import numba
import numpy as np
import numpy.typing as npt

from risorius.evaluators.competition import compete, compete_slopes, fit_competition
from risorius.evaluators.hermite import DERIVATIVE_WEIGHTS, FOLDS, NormalEquations, best_choice
from risorius.evaluators.kinks import bend, bend_slopes, fit_kinks
from risorius.evaluators.observations import Observations
from risorius.evaluators.products import (
    Products,
    Term,
    as_products,
    choose_terms,
    multiply,
    multiply_slopes,
    needed,
)
from risorius.evaluators.setting import Setting
from risorius.jaw import FloatArray
from risorius.part import Part

# Of a feature, which is of the order of 1 where it counts: what is left of an asymmetry by rounding is less.
NEGLIGIBLE = 1e-9
# Of all modes together; at 4 bytes they fit in 1 MB of cache.
MOST_COEFFICIENTS = 250_000
KINK_SCALE = 0.03  # size that is expected of a kink's coefficients, where that of a single activation is 1
BATCH = 16  # snapshots whose terms are held at once


@dataclass(frozen=True)
class Block:
    """Modes that the same features drive.

    terms (n, 2), signs (n,): feature k is term terms[k, 0] plus signs[k] times term terms[k, 1].
    modes (r,): their positions among all. coefficients (n, r): modal coordinates per unit of a feature.
    """

    terms: npt.NDArray[np.int32]
    signs: npt.NDArray[np.float64]
    modes: npt.NDArray[np.int64]
    coefficients: npt.NDArray[np.float32]

    def leading(self, rank: int) -> Block:
        """Return that of the modes before `rank`, which may be none."""
        kept = self.modes < rank
        return replace(self, modes=self.modes[kept], coefficients=np.ascontiguousarray(self.coefficients[:, kept]))

    def within(self, part: Part, alive: npt.NDArray[np.bool_]) -> Block:
        """Return that of the modes of a part where only some of the terms (m,) are not 0."""
        first, second = self.terms.T
        has_first, has_second = alive[first], alive[second] & (self.signs != 0.0)
        kept = np.flatnonzero(has_first | has_second)
        left = np.where(has_first, first, second)
        right = np.where(has_first & has_second, second, left)
        signs = np.where(has_first & has_second, self.signs, 0.0)
        factor = np.where(has_first, 1.0, self.signs)[kept, None]
        ours = np.isin(self.modes, part.modes)
        coefficients = factor * self.coefficients[np.ix_(kept, ours)]
        return Block(
            terms=np.column_stack([left, right])[kept],
            signs=signs[kept],
            modes=np.searchsorted(part.modes, self.modes[ours]),
            coefficients=coefficients.astype(np.float32),
        )

    def write(self, group: h5py.Group) -> None:
        """Store all fields."""
        group["terms"], group["signs"], group["modes"] = self.terms, self.signs, self.modes
        group["coefficients"] = self.coefficients

    @classmethod
    def read(cls, group: h5py.Group) -> Block:
        """Load what `write` stored."""
        return cls(*(group[name][()] for name in ("terms", "signs", "modes", "coefficients")))


@dataclass(frozen=True)
class RationalMap:
    """competition: (p, p) weights of `competition`; products of the b; kinks (p, h) of `kinks`; blocks of modes.

    Not thread-safe.
    """

    competition: FloatArray
    products: Products
    kinks: FloatArray
    blocks: tuple[Block, ...]
    name = "rational"
    doubt = 0.0

    @cached_property
    def _work(self) -> tuple[FloatArray, FloatArray, FloatArray, npt.NDArray[np.int64], npt.NDArray[np.float32]]:
        """Variables, terms, active features and their positions, coordinates of a block."""
        longest = max(len(block.terms) for block in self.blocks)
        widest = max(len(block.modes) for block in self.blocks)
        return (
            np.empty(len(self.competition)),
            np.empty(len(self.products.parents) + self.kinks.shape[1]),
            np.empty(longest),
            np.empty(longest, np.int64),
            np.empty(widest, np.float32),
        )

    def coordinates(self, parameters: FloatArray, out: FloatArray) -> None:
        """Write the modal coordinates (r,) of parameters (p,) into `out`."""
        variables, terms, active, positions, sums = self._work
        compete(parameters, self.competition, variables)
        count = len(self.products.parents)
        multiply(variables, self.products.parents, self.products.factors, terms[:count])
        bend(variables, self.kinks, terms[count:])
        for block in self.blocks:
            _add_up(terms, block.terms, block.signs, block.coefficients, block.modes, active, positions, sums, out)

    def at(self, setting: Setting) -> RationalMap:
        """Return that of the leading modes."""
        return replace(self, blocks=tuple(block.leading(setting.rank) for block in self.blocks))

    def within(self, part: Part) -> RationalMap:
        """Return that of a part, without the terms of parameters that it has not or that are always 0."""
        bent = (self.kinks[part.parameters[part.driven]] != 0.0).any(axis=0)
        alive = np.concatenate([self.products.alive(part), bent])
        blocks = tuple(block.within(part, alive) for block in self.blocks)
        left = replace(self, blocks=blocks)._compacted()
        number = np.zeros(len(self.competition), np.int32)
        number[part.parameters] = np.arange(len(part.parameters))
        products = Products(left.products.parents, number[left.products.factors])
        competition = self.competition[np.ix_(part.parameters, part.parameters)]
        kinks = np.ascontiguousarray(left.kinks[part.parameters])
        return RationalMap(np.ascontiguousarray(competition), products, kinks, left.blocks)

    def write(self, group: h5py.Group) -> None:
        """Store weights, terms and coefficients."""
        group["competition"], group["kinks"] = self.competition, self.kinks
        self.products.write(group)
        for number, block in enumerate(self.blocks):
            block.write(group.create_group(f"blocks/{number}"))

    @classmethod
    def read(cls, group: h5py.Group) -> RationalMap:
        """Load what `write` stored."""
        blocks = tuple(Block.read(group[f"blocks/{number}"]) for number in range(len(group["blocks"])))
        return cls(group["competition"][()], Products.read(group), group["kinks"][()], blocks)

    @classmethod
    def fit(cls, observations: Observations) -> RationalMap:
        """Fit to snapshots; ridge and weight of the derivatives are chosen by cross-validation over them."""
        competition = fit_competition(observations)
        kinks = fit_kinks(observations, competition)
        scales = choose_terms(observations)
        products = as_products(list(scales))
        scale = np.concatenate([list(scales.values()), np.full(kinks.shape[1], KINK_SCALE)])
        full = cls(competition, products, kinks, tuple(_features(list(scales), kinks.shape[1], observations)))
        systems = _equations(observations, full, scale)
        choice = best_choice(systems, DERIVATIVE_WEIGHTS if observations.derivatives is not None else (0.0,))
        blocks = []
        for system, block in zip(systems, full.blocks, strict=True):
            share = MOST_COEFFICIENTS // observations.coordinates.shape[1]
            kept = system.most_telling(choice, share)
            size = scale[block.terms[kept, 0]][:, None]
            coefficients = (size * system.solution(choice, kept)).astype(np.float32)
            blocks.append(Block(block.terms[kept], block.signs[kept], block.modes, coefficients))
        return replace(full, blocks=tuple(blocks))._compacted()

    def _compacted(self) -> RationalMap:
        """The same map without the terms that no feature needs."""
        used, count = np.concatenate([block.terms for block in self.blocks]), len(self.products.parents)
        multiplied = used < count
        products, numbers = needed(self.products, used[multiplied])
        kept, positions = np.unique(used[~multiplied] - count, return_inverse=True)
        used[multiplied], used[~multiplied] = numbers, len(products.parents) + positions
        parts = np.split(used, np.cumsum([len(block.terms) for block in self.blocks])[:-1])
        blocks = tuple(replace(block, terms=part) for block, part in zip(self.blocks, parts, strict=True))
        return RationalMap(self.competition, products, np.ascontiguousarray(self.kinks[:, kept]), blocks)


def _features(terms: list[Term], kinks: int, observations: Observations) -> list[Block]:
    """Blocks without coefficients, of products and then so many kinks: one of all, or two of a symmetric face."""
    empty = np.zeros((0, 0), np.float32)
    reflection, count = observations.reflection, len(terms)
    if reflection is None:
        every = np.arange(count + kinks, dtype=np.int32)
        modes = np.arange(observations.coordinates.shape[1])
        return [Block(np.column_stack([every, every]), np.zeros(count + kinks), modes, empty)]
    position = {term: number for number, term in enumerate(terms)}
    image = [position[tuple(sorted(reflection.partner[list(term)]))] for term in terms]
    sign = [reflection.sign[list(term)].prod() for term in terms]
    # Kinks come in two halves, each the image of the other.
    first = np.arange(count + kinks)
    second = np.concatenate([image, np.roll(first[count:], kinks // 2)])
    turned = np.concatenate([sign, np.ones(kinks)])
    blocks = []
    for parity in (1.0, -1.0):
        kept = (first < second) | ((first == second) & (turned == parity))
        signs = np.where(first == second, 0.0, parity * turned)[kept]
        pairs = np.column_stack([first, second])[kept].astype(np.int32)
        blocks.append(Block(pairs, signs, np.flatnonzero(reflection.parity == parity), empty))
    return blocks


def _equations(observations: Observations, full: RationalMap, scale: FloatArray) -> list[NormalEquations]:
    """Normal equations of each block of a map; its coefficients are those of features divided by their scale."""
    systems = [NormalEquations(len(block.terms), len(block.modes)) for block in full.blocks]
    for fold in range(FOLDS):
        rows = np.arange(fold, len(observations.parameters), FOLDS)
        for start in range(0, len(rows), BATCH):
            batch = [_terms_of(observations, row, full) for row in rows[start : start + BATCH]]
            for system, block in zip(systems, full.blocks, strict=True):
                first, second = block.terms.T
                combined = [
                    np.hstack(
                        [(terms[:, first] + block.signs * terms[:, second]) * scale[first], targets[:, block.modes]]
                    )
                    for terms, targets in batch
                ]
                slopes = np.concatenate([one[1:] for one in combined]).astype(np.float32)
                system.add(fold, np.stack([one[0] for one in combined]), slopes)
    return systems


def _terms_of(observations: Observations, row: int, full: RationalMap) -> tuple[FloatArray, FloatArray]:
    """All terms (1 + p, m) of a snapshot and its coordinates (1 + p, r): the value, then the derivatives if known."""
    count, products = len(full.competition), full.products
    variables, slopes = np.empty(count), np.empty((count, count))
    values, gradients = np.empty(len(products.parents)), np.empty((len(products.parents), count))
    compete_slopes(observations.parameters[row], full.competition, variables, slopes)
    multiply_slopes(variables, slopes, products.parents, products.factors, values, gradients)
    bent, bent_gradients = bend_slopes(variables, slopes, full.kinks)
    values, gradients = np.concatenate([values, bent]), np.vstack([gradients, bent_gradients])
    if observations.derivatives is None:
        return values[None], observations.coordinates[row][None]
    targets = np.vstack([observations.coordinates[row], observations.derivatives[row]])
    return np.vstack([values, gradients.T]), targets


@numba.njit(cache=True, fastmath={"contract"})
def _add_up(terms, pairs, signs, coefficients, modes, active, positions, sums, out):  # type: ignore[no-untyped-def]
    """Write the coordinates of a block into their places in `out`, features that are negligible left out."""
    count = 0
    for n in range(len(pairs)):
        value = terms[pairs[n, 0]] + signs[n] * terms[pairs[n, 1]]
        active[count], positions[count] = value, n
        count += abs(value) > NEGLIGIBLE
    width = len(modes)
    for r in range(width):
        sums[r] = 0.0
    whole = count - count % 4
    for k in range(0, whole, 4):
        a, b, c, d = (
            np.float32(active[k]), np.float32(active[k + 1]), np.float32(active[k + 2]), np.float32(active[k + 3])
        )  # fmt: skip
        i, j, m, n = positions[k], positions[k + 1], positions[k + 2], positions[k + 3]
        for r in range(width):
            sums[r] += a * coefficients[i, r] + b * coefficients[j, r] + c * coefficients[m, r] + d * coefficients[n, r]
    for k in range(whole, count):
        a, i = np.float32(active[k]), positions[k]
        for r in range(width):
            sums[r] += a * coefficients[i, r]
    for r in range(width):
        out[modes[r]] = sums[r]
