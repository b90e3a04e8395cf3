"""Fields by which skin is moved out of contact: smooth bumps that add up to one, so that nothing dents.

Controls lie SPACING apart on the surface; each carries a bump (Wendland 1995, C2) of geodesic RADIUS, divided by the
sum of all bumps there. What is moved fades out over some RADIUS beyond the points that may touch.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
from scipy.sparse.csgraph import dijkstra

from risorius.geodesics import distances_from, edge_lengths
from risorius.jaw import FloatArray

SPACING, RADIUS = 4e-3, 7e-3


def correction_shares(
    rest: npt.NDArray[np.floating], triangles: npt.NDArray[np.int32], touching: npt.NDArray[np.integer]
) -> sp.csr_matrix:
    """Shares (n, c), between 0 and 1, of the vertices of a surface (n, 3) in controls about those that may touch."""
    if not len(touching):
        return sp.csr_matrix((len(rest), 0))
    points = rest.astype(np.float64)
    graph = edge_lengths(points, triangles)
    away = distances_from(graph, touching, 3.0 * RADIUS)
    around = np.flatnonzero(away < np.inf)
    bumps = _bumps(points[around], graph[around][:, around])
    sums = np.maximum(np.asarray(bumps.sum(axis=0)).ravel(), np.finfo(float).tiny)
    shares = sp.csr_matrix(bumps @ sp.diags(1.0 / sums))
    shares = shares[shares[:, np.isin(around, touching)].getnnz(axis=1) > 0].tocoo()
    return sp.csr_matrix((shares.data, (around[shares.col], shares.row)), shape=(len(rest), shares.shape[0]))


def _bumps(points: FloatArray, graph: sp.csr_matrix) -> sp.csr_matrix:
    """(c, n) bumps of controls SPACING apart, from the plane of symmetry outwards, so that both sides are alike.

    One after the other: all distances at once would take memory as the square of the surface.
    """
    free = ~beside_middle(points, SPACING)
    rows = []
    for vertex in outwards(points):
        if not free[vertex]:
            continue
        distance = dijkstra(graph, directed=False, indices=vertex, limit=RADIUS)
        free &= distance > SPACING
        ratio = np.minimum(distance / RADIUS, 1.0)
        rows.append(sp.csr_matrix((1.0 - ratio) ** 4 * (4.0 * ratio + 1.0)))
    return sp.csr_matrix(sp.vstack(rows))


def outwards(points: FloatArray) -> npt.NDArray[np.int64]:
    """Numbers of points (n, 3) from the plane of symmetry, x = 0, outwards, mirror images after each other."""
    places = np.round(points, 7)
    return np.lexsort((places[:, 2], places[:, 1], np.abs(places[:, 0])))


def beside_middle(points: FloatArray, spacing: float) -> npt.NDArray[np.bool_]:
    """Points (n, 3) that are nearer than `spacing` to their mirror image, and not on the plane of symmetry."""
    away = np.abs(points[:, 0])
    return np.asarray((away > 1e-7) & (away < 0.5 * spacing))
