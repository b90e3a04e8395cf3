"""Signed distances from the points of a regular grid to a triangulated surface, exact in a band around it.

The sign is that of the angle-weighted pseudonormal at the nearest point (Baerentzen and Aanaes 2005), which is right
also where the nearest point lies on an edge or a corner. A surface may be open: what lies beyond its border, nearest
to a point of the border itself, is outside.
"""

from __future__ import annotations

import itertools
import math

import numba
import numpy as np
from scipy import ndimage

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.anatomy.anatomy import Surface
from risorius_offline.discretisation import IntArray

_compiled = numba.njit(cache=True, error_model="numpy")

# Features of a triangle abc on which a nearest point may lie.
_FACE, _AB, _BC, _CA, _A, _B, _C = range(7)


def signed_distances(
    surface: Surface, origin: FloatArray, spacing: float, shape: tuple[int, int, int], band: float
) -> FloatArray:
    """Distances in metres (shape) at origin + spacing (i, j, k), negative inside, cut off at +-band.

    The grid reaches beyond the surface by more than the band. Raises InputError as `pseudonormals`.
    """
    squares, signs = np.full(shape, band * band), np.zeros(shape, dtype=np.int8)
    _sample(surface.points[surface.triangles], pseudonormals(surface), origin, spacing, squares, signs)
    _fill(signs)
    return np.sqrt(squares) * signs


def pseudonormals(surface: Surface) -> FloatArray:
    """Outward directions (m, 7, 3), not normalised, of each triangle's face, three edges and three corners.

    They are zero on the border of an open surface. Triangles that enclose a negative volume are turned over. Raises
    InputError where triangles of one surface are wound differently, or more than two meet at an edge.
    """
    corners = surface.points[surface.triangles]
    edges = np.roll(corners, -1, axis=1) - corners
    normal = np.cross(edges[:, 0], edges[:, 1])
    if np.einsum("tci,ti->", corners - surface.points.mean(axis=0), normal) < 0.0:
        normal = -normal
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    edge, on_border = _edges(surface.triangles)
    by_edge = np.zeros((edge.max() + 1, 3))
    np.add.at(by_edge, edge, normal[:, None])
    by_edge[edge[on_border]] = 0.0
    back = -np.roll(edges, 1, axis=1)
    angle = np.arctan2(np.linalg.norm(np.cross(edges, back), axis=2), np.einsum("tci,tci->tc", edges, back))
    by_corner = np.zeros_like(surface.points)
    np.add.at(by_corner, surface.triangles, angle[:, :, None] * normal[:, None])
    by_corner[surface.triangles[on_border]] = 0.0
    by_corner[np.roll(surface.triangles, -1, axis=1)[on_border]] = 0.0
    return np.concatenate([normal[:, None], by_edge[edge], by_corner[surface.triangles]], axis=1)


def _edges(triangles: IntArray) -> tuple[IntArray, np.ndarray]:
    """Edge numbers (m, 3) of ab, bc, ca, and flags (m, 3) of edges with one triangle only."""
    directed = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    different, count = np.unique(directed, axis=0, return_counts=True)
    if count.max() > 1:
        a, b = different[count.argmax()]
        raise InputError(
            f"{count.max()} triangles run from point {a} to point {b}; "
            "wind neighbouring triangles alike and let two meet at an edge"
        )
    _, edge, count = np.unique(np.sort(directed, axis=1), axis=0, return_inverse=True, return_counts=True)
    edge = edge.reshape(-1, 3)
    return edge, count[edge] == 1


def _fill(signs: np.ndarray) -> None:
    """Give every connected part of the points beyond the band (sign 0) the sign of most of its neighbours."""
    part, count = ndimage.label(signs == 0)
    votes = np.zeros(count + 1)
    ahead, behind = slice(1, None), slice(None, -1)
    for axis, (here, there) in itertools.product(range(3), [(ahead, behind), (behind, ahead)]):
        where = (slice(None),) * axis
        votes += np.bincount(part[(*where, here)].ravel(), weights=signs[(*where, there)].ravel(), minlength=count + 1)
    votes[0] = 0.0
    signs += np.sign(votes).astype(np.int8)[part]


@_compiled
def _sample(corners, normals, origin, spacing, squares, signs):  # type: ignore[no-untyped-def]
    """Lower `squares`, squared distances, to those of triangles (m, 3, 3), and set `signs` where that happens."""
    band = math.sqrt(squares[0, 0, 0])
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    for t in range(len(corners)):
        corner, normal = corners[t], normals[t]
        face = normal[_FACE]
        for axis in range(3):
            low[axis] = math.ceil((corner[:, axis].min() - band - origin[axis]) / spacing)
            high[axis] = math.floor((corner[:, axis].max() + band - origin[axis]) / spacing)
        for i in range(low[0], high[0] + 1):
            x = origin[0] + spacing * i - corner[0, 0]
            for j in range(low[1], high[1] + 1):
                y = origin[1] + spacing * j - corner[0, 1]
                for k in range(low[2], high[2] + 1):
                    z = origin[2] + spacing * k - corner[0, 2]
                    height = face[0] * x + face[1] * y + face[2] * z
                    if height * height >= squares[i, j, k]:
                        continue
                    feature, dx, dy, dz = _offset(corner, x, y, z)
                    square = dx * dx + dy * dy + dz * dz
                    if square < squares[i, j, k]:
                        squares[i, j, k] = square
                        side = normal[feature, 0] * dx + normal[feature, 1] * dy + normal[feature, 2] * dz
                        signs[i, j, k] = 1 if side >= 0.0 else -1


@_compiled
def _offset(corner, x, y, z):  # type: ignore[no-untyped-def]
    """Feature of triangle abc nearest to p = a + (x, y, z), and p minus the nearest point (Ericson 2005, 5.1.5)."""
    abx, aby, abz = corner[1, 0] - corner[0, 0], corner[1, 1] - corner[0, 1], corner[1, 2] - corner[0, 2]
    acx, acy, acz = corner[2, 0] - corner[0, 0], corner[2, 1] - corner[0, 1], corner[2, 2] - corner[0, 2]
    d1 = abx * x + aby * y + abz * z
    d2 = acx * x + acy * y + acz * z
    d3 = d1 - (abx * abx + aby * aby + abz * abz)
    d4 = d2 - (abx * acx + aby * acy + abz * acz)
    d5 = d1 - (abx * acx + aby * acy + abz * acz)
    d6 = d2 - (acx * acx + acy * acy + acz * acz)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if d1 <= 0.0 and d2 <= 0.0:
        feature, v, w = _A, 0.0, 0.0
    elif d3 >= 0.0 and d4 <= d3:
        feature, v, w = _B, 1.0, 0.0
    elif d6 >= 0.0 and d5 <= d6:
        feature, v, w = _C, 0.0, 1.0
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        feature, v, w = _AB, d1 / (d1 - d3), 0.0
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        feature, v, w = _CA, 0.0, d2 / (d2 - d6)
    elif va <= 0.0 and d4 >= d3 and d5 >= d6:
        w = (d4 - d3) / (d4 - d3 + d5 - d6)
        feature, v = _BC, 1.0 - w
    else:
        feature, v, w = _FACE, vb / (va + vb + vc), vc / (va + vb + vc)
    return feature, x - v * abx - w * acx, y - v * aby - w * acy, z - v * abz - w * acz
