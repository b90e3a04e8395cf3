"""Border of a triangulated surface."""

from __future__ import annotations

import numpy as np

from risorius_offline.discretisation import IntArray


def border_edges(triangles: IntArray) -> IntArray:
    """Edges (k, 2) of triangles (m, 3) that no other one has in the opposite sense, directed as their triangle's."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    size = triangles.max() + 1
    return edges[~np.isin(edges[:, 0] * size + edges[:, 1], edges[:, 1] * size + edges[:, 0])]
