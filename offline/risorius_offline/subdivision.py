"""A finer, smoother triangulation carried by a coarse one: square-root-of-three subdivision (Kobbelt 2000)."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from risorius_offline.discretisation import IntArray


def refine(triangles: IntArray, count: int, steps: int) -> tuple[sp.csr_matrix, IntArray]:
    """Weights (fine, count) and triangles after some steps; every step has three times as many triangles.

    Fine points are weights @ coarse points, old ones first, and smooth where the surface goes on; on its boundary old
    points stay where they are and edges are kept. Rows of the weights sum to one.
    """
    weights = sp.identity(count, format="csr")
    for _ in range(steps):
        step, triangles = _step(triangles, weights.shape[0])
        weights = (step @ weights).tocsr()
    return weights, triangles


def _step(triangles: IntArray, count: int) -> tuple[sp.csr_matrix, IntArray]:
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    owner = np.repeat(np.arange(len(triangles)), 3)
    half = {(int(a), int(b)): int(t) for a, b, t in zip(start, end, owner, strict=True)}
    middle = count + np.arange(len(triangles))
    fine = []
    for a, b, t in zip(start, end, owner, strict=True):
        across = half.get((int(b), int(a)))
        if across is None:
            fine.append((a, b, middle[t]))
        else:
            fine.append((a, middle[across], middle[t]))
    return _weights(triangles, half, count), np.array(fine, dtype=np.int64)


def _weights(triangles: IntArray, half: dict[tuple[int, int], int], count: int) -> sp.csr_matrix:
    edges = np.array(list(half), dtype=np.int64)
    neighbours = sp.csr_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
    open_edges = edges[[(b, a) not in half for a, b in half]]
    inner = np.ones(count, dtype=bool)
    inner[open_edges.ravel()] = False
    valence = np.asarray(neighbours.sum(axis=1)).ravel()
    inner &= valence > 0
    share = np.where(inner, (4.0 - 2.0 * np.cos(2.0 * np.pi / np.maximum(valence, 1.0))) / 9.0, 0.0)
    kept = sp.diags(1.0 - share) + sp.diags(share / np.maximum(valence, 1.0)) @ neighbours
    rows = np.repeat(np.arange(len(triangles)), 3)
    centres = sp.csr_matrix((np.full(len(rows), 1.0 / 3.0), (rows, triangles.ravel())), shape=(len(triangles), count))
    return sp.vstack([kept, centres]).tocsr()
