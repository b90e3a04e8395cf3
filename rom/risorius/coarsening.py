"""A surface with one vertex for each point of the mesh that carries the skin, out of the vertices that there are.

Triangles are those of the geodesic Delaunay triangulation (Peyre and Cohen 2006): three vertices are joined where the
parts of the fine surface that are nearest to each, along its edges, meet.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
from scipy.sparse.csgraph import dijkstra

Numbers = npt.NDArray[np.int64]
Triangles = npt.NDArray[np.int32]


def coarse_surface(
    points: npt.NDArray[np.float32], triangles: Triangles, weights: sp.csr_matrix
) -> tuple[Numbers, Triangles]:
    """Numbers (k,) of the vertices that are kept, ascending, and triangles (t, 3) in the numbers of these.

    points (n, 3); triangles (m, 3); weights (n, c) of the carriers: of each carrier the vertex that follows it most.
    """
    used = np.unique(triangles)
    follows = np.asarray(weights[used].argmax(axis=0)).ravel()
    largest = np.asarray(weights[used].max(axis=0).todense()).ravel()
    kept = np.unique(used[follows[largest > 0.0]])
    cell = _nearest(points, triangles, kept)[triangles]
    corners = cell[(cell[:, 0] != cell[:, 1]) & (cell[:, 1] != cell[:, 2]) & (cell[:, 2] != cell[:, 0])]
    turned = np.take_along_axis(corners, (corners.argmin(axis=1)[:, None] + np.arange(3)) % 3, axis=1)
    return kept, np.searchsorted(kept, np.unique(turned, axis=0)).astype(np.int32)


def _nearest(points: npt.NDArray[np.float32], triangles: Triangles, sources: Numbers) -> Numbers:
    """(n,) which source is nearest to each point along the edges; of points that none is joined to, themselves."""
    start, end = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).T
    length = np.linalg.norm(points[start] - points[end], axis=1).astype(np.float64)
    graph = sp.coo_matrix((length, (start, end)), shape=(len(points), len(points))).tocsr()
    graph = graph.maximum(graph.T)
    _, _, found = dijkstra(graph, directed=False, indices=sources, min_only=True, return_predecessors=True)
    return np.where(found >= 0, found, np.arange(len(points)))
