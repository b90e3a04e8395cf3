"""Energy-conserving sampling and weighting (Farhat, Avery, Chapman and Cortial 2014).

Few elements with weights that are not negative stand for all: the weights minimise the error of the reduced forces of
training states, so that the reduced energy stays a sum of energies of real elements, as stable as these.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.linalg as sl
import scipy.sparse as sp

from risorius.hyper_reduction.terms import Term
from risorius.jaw import FloatArray

# Elements that are taken at once, of those that the remaining forces ask for most.
AT_ONCE = 8


@dataclass(frozen=True)
class Cubature:
    """Chosen elements of every term and their weights, with the part of the training forces that these miss."""

    elements: tuple[npt.NDArray[np.int64], ...]
    weights: tuple[FloatArray, ...]
    missed: float

    @property
    def size(self) -> int:
        """Number of elements."""
        return sum(map(len, self.elements))


def element_forces(terms: Sequence[Term], u: FloatArray, modes: FloatArray) -> FloatArray:
    """Forces (e, r) of all elements of the terms on modes (r, n, 3) at a displacement u (n, 3) of all nodes."""
    flat, parts = modes.reshape(len(modes), -1).T, []
    for term in terms:
        dofs = node_components(term.connectivity)
        term.deform(np.ascontiguousarray(u.reshape(-1)[dofs]))
        starts = np.arange(0, dofs.size + 1, len(dofs))
        forces = sp.csr_matrix((term.forces().T.ravel(), dofs.T.ravel(), starts), shape=(dofs.shape[1], u.size))
        parts.append(forces @ flat)
    return np.concatenate(parts)


def node_components(connectivity: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """(3 a, e) numbers of the components of the nodes of every element."""
    return np.ascontiguousarray((3 * connectivity[:, :, None] + np.arange(3)).reshape(len(connectivity), -1).T)


def choose(columns: npt.NDArray[np.float32], sizes: Sequence[int], count: int, tolerance: float) -> Cubature:
    """Choose at most `count` elements, fewer where these miss no more than `tolerance` of the forces.

    columns: (e, rows) forces of every element in all training states, in a metric of choice; sizes: elements of every
    term. The target is their sum.
    """
    target = columns.sum(axis=0, dtype=np.float64)
    chosen, weights, missed = _nonnegative_least_squares(columns, target, count, tolerance)
    order = np.argsort(chosen)
    chosen, weights = chosen[order], weights[order]
    starts = np.concatenate([[0], np.cumsum(sizes)])
    parts = [(chosen >= start) & (chosen < end) for start, end in itertools.pairwise(starts)]
    return Cubature(
        tuple(chosen[part] - start for part, start in zip(parts, starts[:-1], strict=True)),
        tuple(weights[part] for part in parts),
        missed,
    )


def _nonnegative_least_squares(
    columns: npt.NDArray[np.float32], target: FloatArray, count: int, tolerance: float
) -> tuple[npt.NDArray[np.int64], FloatArray, float]:
    """Active set method of Lawson and Hanson (1974) with several columns at once, stopped early."""
    chosen, weights = np.zeros(0, np.int64), np.zeros(0)
    size = float(np.linalg.norm(target))
    lengths = np.maximum(np.linalg.norm(columns, axis=1), np.finfo(np.float32).tiny)
    residual, missed = target, 1.0
    while missed > tolerance and len(chosen) < count:
        wanted = (columns @ residual.astype(np.float32)) / lengths
        wanted[chosen] = 0.0
        best = np.argsort(wanted)[::-1][: min(AT_ONCE, count - len(chosen))]
        best = best[wanted[best] > 0.0]
        before = missed
        chosen, weights = _feasible(
            columns, target, np.concatenate([chosen, best]), np.concatenate([weights, np.zeros(len(best))])
        )
        residual = target - weights @ columns[chosen].astype(np.float64)
        missed = float(np.linalg.norm(residual)) / size
        if not len(best) or missed >= before:
            break
    return chosen, weights, missed


def _feasible(
    columns: npt.NDArray[np.float32], target: FloatArray, chosen: npt.NDArray[np.int64], weights: FloatArray
) -> tuple[npt.NDArray[np.int64], FloatArray]:
    """Best positive weights of chosen columns; columns that would need another sign are dropped, one after another."""
    used = columns[chosen].astype(np.float64)
    gram, right = used @ used.T, used @ target
    kept = np.arange(len(chosen))
    while True:
        part = gram[np.ix_(kept, kept)]
        ridge = 1e-12 * np.trace(part) / len(kept)
        best = sl.cho_solve(sl.cho_factor(part + ridge * np.eye(len(kept))), right[kept])
        if (best > 0.0).all():
            return chosen[kept], best
        falling = best <= 0.0
        now = weights[kept]
        step = float(np.min(now[falling] / (now[falling] - best[falling]), initial=1.0))
        weights[kept] = now + step * (best - now)
        kept = kept[~(falling & (weights[kept] <= 1e-12 * weights.max(initial=1e-300)))]
