"""Bases of the reduced model."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from risorius.jaw import FloatArray

# Snapshots are single precision: smaller singular values, relative to the largest, are rounding.
ROUNDING = 1e-6
# Of the least possible projection error, squared: what another pass over the snapshots has to win to be worth it.
WORTH_A_PASS = 1e-6
OVERSAMPLING = 8
LARGEST_SUBSPACE = 8  # blocks of rank + OVERSAMPLING vectors


def pod(
    blocks: Callable[[], Iterable[FloatArray]], weights: FloatArray, rank: int, seed: int = 0
) -> tuple[FloatArray, FloatArray]:
    """Proper orthogonal decomposition of snapshots, orthonormal under nodal weights (n,).

    blocks: returns all snapshots, (b, n, 3) at a time, in the same order whenever it is called; memory is never taken
    for more than one block. Returns modes (r, n, 3), with r = rank or the rank of the snapshots if that is less, and
    their singular values (r,).

    A randomised block Krylov method (Musco and Musco 2015) with a Rayleigh-Ritz projection, one pass over the snapshots
    a block. It ends when a pass no longer improves the projection error, or, always, when the subspace is exhausted.
    """
    nodes, root = len(weights), np.sqrt(np.repeat(weights, 3))
    start, total = _random_combinations(blocks, root, rank + OVERSAMPLING, seed)
    basis = _orthonormal(start, np.zeros((3 * nodes, 0)))
    gram = np.zeros((0, 0))
    captured, news = 0.0, basis
    for _ in range(LARGEST_SUBSPACE):
        product = _correlate(blocks, root, news)
        gram = _bordered(gram, basis.T @ product)
        best = np.linalg.eigvalsh(gram)[::-1][:rank].sum()
        missed = max(total - best, 0.0) * WORTH_A_PASS + ROUNDING**2 * total
        news = _orthonormal(product, basis)
        if best - captured <= missed or not news.size:
            break
        captured, basis = best, np.hstack([basis, news])
    values, vectors = np.linalg.eigh(gram)
    singular = np.sqrt(np.maximum(values[::-1], 0.0))[:rank]
    kept = int((singular > ROUNDING * singular[0]).sum())
    modes = (basis[:, : len(gram)] @ vectors[:, ::-1][:, :kept]).T / root
    return modes.reshape(kept, nodes, 3), singular[:kept]


def _random_combinations(
    blocks: Callable[[], Iterable[FloatArray]], root: FloatArray, count: int, seed: int
) -> tuple[FloatArray, float]:
    """Random combinations (3 n, count) of the scaled snapshots, and the sum of all their squares."""
    rng = np.random.default_rng(seed)
    result, total = np.zeros((len(root), count)), 0.0
    for block in blocks():
        scaled = block.reshape(len(block), -1) * root
        result += scaled.T @ rng.normal(size=(len(block), count))
        total += float(np.vdot(scaled, scaled))
    return result, total


def _correlate(blocks: Callable[[], Iterable[FloatArray]], root: FloatArray, vectors: FloatArray) -> FloatArray:
    """Product A'A v (3 n, k) of vectors (3 n, k) with the correlation of the scaled snapshots, the rows of A."""
    result = np.zeros_like(vectors)
    for block in blocks():
        scaled = block.reshape(len(block), -1) * root
        result += scaled.T @ (scaled @ vectors)
    return result


def _orthonormal(vectors: FloatArray, against: FloatArray) -> FloatArray:
    """Orthonormal vectors (3 n, <= k) that span what vectors (3 n, k) add to the orthonormal `against` (3 n, m)."""
    sizes = np.linalg.norm(vectors, axis=0)
    rest = vectors[:, sizes > 0.0] / sizes[sizes > 0.0]
    for _ in range(2):  # twice is enough (Giraud et al. 2005)
        rest = rest - against @ (against.T @ rest)
    factors, triangle = np.linalg.qr(rest)
    new = np.abs(np.diag(triangle)) > ROUNDING**2
    factors = factors[:, new] - against @ (against.T @ factors[:, new])
    return np.linalg.qr(factors)[0]


def _bordered(gram: FloatArray, columns: FloatArray) -> FloatArray:
    """Symmetric matrix with the last columns (m, k) added to it."""
    old = len(gram)
    result = np.empty((len(columns), len(columns)))
    result[:old, :old] = gram
    result[:, old:] = columns
    result[old:, :old] = columns[:old].T
    return 0.5 * (result + result.T)
