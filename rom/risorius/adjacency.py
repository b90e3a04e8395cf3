"""Adjacency of the triangles of a surface: across edges and around vertices."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
import numpy.typing as npt

Number = TypeVar("Number", bound=np.signedinteger)


def triangles_across(triangles: npt.NDArray[Number]) -> npt.NDArray[Number]:
    """Triangles (m, 3) beyond the edges of (m, 3), from corner k to the next; -1 where not exactly two meet."""
    edges = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    across = np.full(len(edges), -1, dtype=triangles.dtype)
    if len(edges):
        _, number, count = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
        sides = np.argsort(number.ravel(), kind="stable")
        sides = sides[(count == 2)[number.ravel()[sides]]].reshape(-1, 2)
        across[sides[:, 0]], across[sides[:, 1]] = sides[:, 1] // 3, sides[:, 0] // 3
    return across.reshape(-1, 3)


def vertex_fans(triangles: npt.NDArray[Number], count: int) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Triangles of (m, 3) around each of so many vertices, (3 m,), and where those of each begin, (count + 1,)."""
    corners = triangles.ravel()
    around = np.argsort(corners, kind="stable") // 3
    return around, np.concatenate([[0], np.cumsum(np.bincount(corners, minlength=count))])
