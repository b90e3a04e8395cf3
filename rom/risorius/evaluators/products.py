"""Products of base variables b (p,): the terms of the learned map.

Each term is an earlier one times one variable, so that all of them, and their derivatives, take one pass.
"""

from __future__ import annotations

from dataclasses import dataclass

import h5py
import numba
import numpy as np
import numpy.typing as npt

from risorius.evaluators.observations import Observations
from risorius.part import Part

MUSCLE_DEGREE, POSE_DEGREE = 3, 5
NEGLIGIBLE_OVERLAP = 0.02
SQUARE_OVERLAP, POSE_OVERLAP, TRIPLE_OVERLAP = 0.5, 0.3, 0.6


@dataclass(frozen=True)
class Products:
    """parents (m,): position of an earlier term, -1 for the constant 1. factors (m,): position of a variable."""

    parents: npt.NDArray[np.int32]
    factors: npt.NDArray[np.int32]

    def alive(self, part: Part) -> npt.NDArray[np.bool_]:
        """(m,) False for terms of a parameter that a part has not or that is always 0 there."""
        acts = np.zeros(int(self.factors.max(initial=-1)) + 1, bool)
        acts[part.parameters[part.driven & (part.parameters < len(acts))]] = True
        alive = np.ones(len(self.parents) + 1, bool)  # the last is the constant
        for term, (parent, factor) in enumerate(zip(self.parents, self.factors, strict=True)):
            alive[term] = alive[parent] and acts[factor]
        return alive[:-1]

    def write(self, group: h5py.Group) -> None:
        """Store all terms."""
        group["parents"], group["factors"] = self.parents, self.factors

    @classmethod
    def read(cls, group: h5py.Group) -> Products:
        """Load what `write` stored."""
        return cls(group["parents"][()], group["factors"][()])


Term = tuple[int, ...]


def choose_terms(observations: Observations) -> dict[Term, float]:
    """Terms, as the sorted variables of each, and the size that is expected of its coefficients.

    Powers of each variable; products of two whose displacement fields overlap; with the square of either, and of three,
    where the overlap is large, or less so with a pose, which takes the tissue to where muscles act differently. The
    size falls with the overlap.
    """
    count, muscles = observations.parameters.shape[1], observations.muscles
    overlap = observations.symmetrised(observations.overlap)
    terms: dict[Term, float] = {}
    for i in range(count):
        for degree in range(1, (MUSCLE_DEGREE if i < muscles else POSE_DEGREE) + 1):
            terms[(i,) * degree] = 1.0
    pairs = [(i, j) for i in range(count) for j in range(i + 1, count) if overlap[i, j] > NEGLIGIBLE_OVERLAP]
    terms |= {pair: float(overlap[pair]) for pair in pairs}
    for i, j in pairs:
        if j >= muscles or overlap[i, j] > SQUARE_OVERLAP:
            terms[i, i, j] = terms[i, j, j] = float(overlap[i, j])
        for k in range(j + 1, count):
            least = float(min(overlap[i, j], overlap[i, k], overlap[j, k]))
            if least > (TRIPLE_OVERLAP if k < muscles else POSE_OVERLAP):
                terms[i, j, k] = least
    sizes = np.sqrt(observations.sizes / np.median(observations.sizes))
    return {term: scale * float(sizes[list(term)].prod()) for term, scale in terms.items()}


def as_products(terms: list[Term]) -> Products:
    """Terms in their order; every term without its last variable, or without its first, has to come before it."""
    position: dict[Term, int] = {(): -1}
    parents, factors = [], []
    for number, term in enumerate(terms):
        shorter, factor = (term[:-1], term[-1]) if term[:-1] in position else (term[1:], term[0])
        parents.append(position[shorter])
        factors.append(factor)
        position[term] = number
    return Products(np.array(parents, np.int32), np.array(factors, np.int32))


def needed(products: Products, used: npt.NDArray[np.int32]) -> tuple[Products, npt.NDArray[np.int32]]:
    """Those terms only that some numbers of terms are, or need; and these numbers among them."""
    keep = np.zeros(len(products.parents) + 1, bool)  # the last is the constant
    keep[used] = True
    for term in range(len(products.parents) - 1, -1, -1):
        if keep[term]:
            keep[products.parents[term]] = True
    number = (np.cumsum(keep) - 1).astype(np.int32)
    number[-1] = -1
    kept = keep[:-1]
    return Products(number[products.parents[kept]], products.factors[kept]), number[used]


@numba.njit(cache=True)
def multiply(variables, parents, factors, out):  # type: ignore[no-untyped-def]
    """Write all terms (m,) of variables (p,)."""
    for m in range(len(parents)):
        parent = parents[m]
        value = variables[factors[m]]
        out[m] = value * out[parent] if parent >= 0 else value


@numba.njit(cache=True)
def multiply_slopes(variables, slopes, parents, factors, values, out):  # type: ignore[no-untyped-def]
    """Write all terms (m,), and out[m, j], their derivatives, from those of the variables, slopes (p, j)."""
    for m in range(len(parents)):
        parent, factor = parents[m], factors[m]
        values[m] = variables[factor]
        out[m] = slopes[factor]
        if parent >= 0:
            values[m] *= values[parent]
            for j in range(out.shape[1]):
                out[m, j] = out[m, j] * values[parent] + out[parent, j] * variables[factor]
