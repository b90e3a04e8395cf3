"""Strain in the plane of the triangles of a surface."""

from __future__ import annotations

import numba
import numpy as np
import numpy.typing as npt

from risorius.errors import InputError

Vectors = npt.NDArray[np.float32]


class SurfaceStrain:
    """Principal Green-Lagrange strains of triangles (m, 3) of a surface with vertices (n, 3) at rest, metres.

    Raises InputError for a triangle that has no area at rest.
    """

    def __init__(self, rest: Vectors, triangles: npt.NDArray[np.int32]) -> None:
        corners = rest[triangles].astype(np.float64)
        along, across = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        length = np.linalg.norm(along, axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            shift = (along * across).sum(axis=1) / length
            height = np.linalg.norm(across - (shift / length)[:, None] * along, axis=1)
        flat = np.flatnonzero(~(height > 0.0))
        if len(flat):
            raise InputError(f"triangle {flat[0]} has no area at rest, so it has no strain; leave strain out")
        self._triangles = triangles
        # Upper triangular: edges at rest in the plane of the triangle, inverted.
        self._inverse = np.column_stack([1.0 / length, -shift / (length * height), 1.0 / height]).astype(np.float32)

    def of(self, vertices: Vectors) -> Vectors:
        """Strains (m, 2), eigenvalues of (F'F - 1) / 2, the larger first, of vertices (n, 3)."""
        result = np.empty((len(self._triangles), 2), np.float32)
        _write(vertices, self._triangles, self._inverse, result)
        return result


@numba.njit(cache=True)
def _write(vertices, triangles, inverse, out):  # type: ignore[no-untyped-def]
    for t in range(len(triangles)):
        i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        p, q, r = inverse[t, 0], inverse[t, 1], inverse[t, 2]
        aa, ab, bb = 0.0, 0.0, 0.0
        for axis in range(3):
            along, across = vertices[j, axis] - vertices[i, axis], vertices[k, axis] - vertices[i, axis]
            a, b = p * along, q * along + r * across
            aa += a * a
            ab += a * b
            bb += b * b
        mean, half = 0.5 * (aa + bb), np.sqrt(0.25 * (aa - bb) ** 2 + ab * ab)
        out[t, 0], out[t, 1] = 0.5 * (mean + half - 1.0), 0.5 * (mean - half - 1.0)
