"""Fields by which skin is moved out of contact: smooth bumps that add up to one, so that nothing dents.

Controls lie SPACING apart on the surface; each carries a bump (Wendland 1995, C2) of geodesic RADIUS, divided by the
sum of all bumps there. What is moved fades out over some RADIUS beyond the points that may touch.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
from scipy.sparse.csgraph import dijkstra

from risorius.jaw import FloatArray
from risorius.lip_sheets import edge_lengths

SPACING, RADIUS = 4e-3, 7e-3


def correction_shares(
    rest: npt.NDArray[np.floating], triangles: npt.NDArray[np.int32], touching: npt.NDArray[np.integer]
) -> sp.csr_matrix:
    """Shares (n, c), between 0 and 1, of the vertices of a surface (n, 3) in controls about those that may touch."""
    if not len(touching):
        return sp.csr_matrix((len(rest), 0))
    points = rest.astype(np.float64)
    graph = edge_lengths(points, triangles)
    away = dijkstra(graph, directed=False, indices=touching, limit=3.0 * RADIUS, min_only=True)
    controls = _spread(points, graph, np.flatnonzero(away < np.inf))
    distance = dijkstra(graph, directed=False, indices=controls, limit=RADIUS)
    ratio = np.minimum(distance / RADIUS, 1.0)
    bumps = (1.0 - ratio) ** 4 * (4.0 * ratio + 1.0)
    shares = bumps / np.maximum(bumps.sum(axis=0), np.finfo(float).tiny)
    used = shares[:, touching].max(axis=1) > 0.0
    result: sp.csr_matrix = sp.csr_matrix(shares[used].T)
    return result


def _spread(points: FloatArray, graph: sp.csr_matrix, among: npt.NDArray[np.integer]) -> npt.NDArray[np.int64]:
    """Vertices SPACING apart, from the plane of symmetry outwards, so that both sides get theirs alike."""
    places = np.round(points[among], 7)
    order = among[np.lexsort((places[:, 2], places[:, 1], np.abs(places[:, 0])))]
    free = np.ones(len(points), dtype=bool)
    chosen = []
    for vertex in order:
        if free[vertex]:
            chosen.append(vertex)
            free &= dijkstra(graph, directed=False, indices=vertex, limit=SPACING) == np.inf
    return np.array(chosen)
