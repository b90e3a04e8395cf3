"""Distances along a triangulated surface, over its edges."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
from scipy.sparse.csgraph import dijkstra

from risorius.jaw import FloatArray


def edge_lengths(points: FloatArray, triangles: npt.NDArray[np.int32]) -> sp.csr_matrix:
    """(n, n) lengths of the edges between points (n, 3), metres."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    lengths = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    return sp.csr_matrix((lengths, edges.T), shape=(len(points),) * 2)


def distances_from(graph: sp.csr_matrix, sources: npt.NDArray[np.integer], limit: float) -> FloatArray:
    """(n,) metres over the edges of a graph to the nearest of some vertices, infinite beyond the limit."""
    if not len(sources):
        return np.full(graph.shape[0], np.inf)
    found: FloatArray = dijkstra(graph, directed=False, indices=np.unique(sources), limit=limit, min_only=True)
    return found
