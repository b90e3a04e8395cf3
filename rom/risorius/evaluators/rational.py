"""The learned map: products of activations that saturate in competition, fitted to snapshots and their derivatives.

On a symmetric face the sum of a term and its mirror image drives the symmetric modes, their difference the others:
half the work of one map for all modes, and half of that again where the input is symmetric.
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
    """competition: (p, p) weights of `competition`; products of the b; blocks of modes. Not thread-safe."""

    competition: FloatArray
    products: Products
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
            np.empty(len(self.products.parents)),
            np.empty(longest),
            np.empty(longest, np.int64),
            np.empty(widest, np.float32),
        )

    def coordinates(self, parameters: FloatArray, out: FloatArray) -> None:
        """Write the modal coordinates (r,) of parameters (p,) into `out`."""
        variables, terms, active, positions, sums = self._work
        compete(parameters, self.competition, variables)
        multiply(variables, self.products.parents, self.products.factors, terms)
        for block in self.blocks:
            _add_up(terms, block.terms, block.signs, block.coefficients, block.modes, active, positions, sums, out)

    def at(self, setting: Setting) -> RationalMap:
        """Return that of the leading modes."""
        return replace(self, blocks=tuple(block.leading(setting.rank) for block in self.blocks))

    def within(self, part: Part) -> RationalMap:
        """Return that of a part, without the terms of parameters that it has not or that are always 0."""
        alive = self.products.alive(part)
        blocks = tuple(block.within(part, alive) for block in self.blocks)
        left = RationalMap(self.competition, self.products, blocks)._compacted()
        number = np.zeros(len(self.competition), np.int32)
        number[part.parameters] = np.arange(len(part.parameters))
        products = Products(left.products.parents, number[left.products.factors])
        competition = self.competition[np.ix_(part.parameters, part.parameters)]
        return RationalMap(np.ascontiguousarray(competition), products, left.blocks)

    def write(self, group: h5py.Group) -> None:
        """Store weights, terms and coefficients."""
        group["competition"] = self.competition
        self.products.write(group)
        for number, block in enumerate(self.blocks):
            block.write(group.create_group(f"blocks/{number}"))

    @classmethod
    def read(cls, group: h5py.Group) -> RationalMap:
        """Load what `write` stored."""
        blocks = tuple(Block.read(group[f"blocks/{number}"]) for number in range(len(group["blocks"])))
        return cls(group["competition"][()], Products.read(group), blocks)

    @classmethod
    def fit(cls, observations: Observations) -> RationalMap:
        """Fit to snapshots; ridge and weight of the derivatives are chosen by cross-validation over them."""
        competition = fit_competition(observations)
        scales = choose_terms(observations)
        terms, scale = list(scales), np.array(list(scales.values()))
        products = as_products(terms)
        candidates = _features(terms, observations)
        systems = _equations(observations, competition, products, scale, candidates)
        choice = best_choice(systems, DERIVATIVE_WEIGHTS if observations.derivatives is not None else (0.0,))
        blocks = []
        for system, block in zip(systems, candidates, strict=True):
            share = MOST_COEFFICIENTS // observations.coordinates.shape[1]
            kept = system.most_telling(choice, share)
            size = scale[block.terms[kept, 0]][:, None]
            coefficients = (size * system.solution(choice, kept)).astype(np.float32)
            blocks.append(Block(block.terms[kept], block.signs[kept], block.modes, coefficients))
        return cls(competition, products, tuple(blocks))._compacted()

    def _compacted(self) -> RationalMap:
        """The same map without the terms that no feature needs."""
        products, numbers = needed(self.products, np.concatenate([block.terms for block in self.blocks]))
        parts = np.split(numbers, np.cumsum([len(block.terms) for block in self.blocks])[:-1])
        blocks = tuple(replace(block, terms=part) for block, part in zip(self.blocks, parts, strict=True))
        return RationalMap(self.competition, products, blocks)


def _features(terms: list[Term], observations: Observations) -> list[Block]:
    """Blocks without coefficients: one of all terms, or two of a symmetric face."""
    empty = np.zeros((0, 0), np.float32)
    reflection = observations.reflection
    if reflection is None:
        every = np.arange(len(terms), dtype=np.int32)
        modes = np.arange(observations.coordinates.shape[1])
        return [Block(np.column_stack([every, every]), np.zeros(len(terms)), modes, empty)]
    position = {term: number for number, term in enumerate(terms)}
    image = np.array([position[tuple(sorted(reflection.partner[list(term)]))] for term in terms])
    sign = np.array([reflection.sign[list(term)].prod() for term in terms])
    pairs = np.column_stack([np.arange(len(terms)), image]).astype(np.int32)
    blocks = []
    for parity in (1.0, -1.0):
        kept = (pairs[:, 0] < image) | ((pairs[:, 0] == image) & (sign == parity))
        signs = np.where(pairs[:, 0] == image, 0.0, parity * sign)[kept]
        blocks.append(Block(pairs[kept], signs, np.flatnonzero(reflection.parity == parity), empty))
    return blocks


def _equations(
    observations: Observations, competition: FloatArray, products: Products, scale: FloatArray, blocks: list[Block]
) -> list[NormalEquations]:
    """Normal equations of each block; its coefficients are those of features divided by their scale."""
    systems = [NormalEquations(len(block.terms), len(block.modes)) for block in blocks]
    for fold in range(FOLDS):
        rows = np.arange(fold, len(observations.parameters), FOLDS)
        for start in range(0, len(rows), BATCH):
            batch = [_terms_of(observations, row, competition, products) for row in rows[start : start + BATCH]]
            for system, block in zip(systems, blocks, strict=True):
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


def _terms_of(
    observations: Observations, row: int, competition: FloatArray, products: Products
) -> tuple[FloatArray, FloatArray]:
    """All terms (1 + p, m) of a snapshot and its coordinates (1 + p, r): the value, then the derivatives if known."""
    count = len(competition)
    variables, slopes = np.empty(count), np.empty((count, count))
    values, gradients = np.empty(len(products.parents)), np.empty((len(products.parents), count))
    compete_slopes(observations.parameters[row], competition, variables, slopes)
    multiply_slopes(variables, slopes, products.parents, products.factors, values, gradients)
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
