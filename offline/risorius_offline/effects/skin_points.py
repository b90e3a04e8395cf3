"""Points of the visible surface as what carries them: nodes and their weights."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray


def carriers(weights: sp.csr_matrix) -> tuple[IntArray, FloatArray]:
    """Nodes (k, m) that carry points, and their weights (k, m), zero where a point has fewer, from weights (k, n)."""
    counts = np.diff(weights.indptr)
    shape = (len(counts), int(counts.max()))
    used = np.arange(shape[1]) < counts[:, None]
    nodes, shares = np.repeat(weights.indices[weights.indptr[:-1], None], shape[1], axis=1), np.zeros(shape)
    nodes[used], shares[used] = weights.indices, weights.data
    return nodes.astype(np.int64), shares
