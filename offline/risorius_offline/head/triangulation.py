"""Triangles of a plane region with holes, even as they lie in space.

Nodes repel each other as in Persson and Strang 2004, but with lengths measured on the mapped surface: forces between
neighbours in space are pulled back to the plane. Diagonals are chosen in space too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial import Delaunay, cKDTree

from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray

STEPS, RETRIANGULATE = 150, 5
PRESSURE = 1.15  # springs are this much longer than there is room for, so that nodes fill the region
RELAXATION = 0.2
LARGEST_MOVE = 2.0  # millimetres a step
INSIDE = -2e-3  # millimetres within which a triangle's centre counts as outside
STENCIL = 0.4  # millimetres
LARGEST_FLIP_SWEEPS = 30


@dataclass(frozen=True)
class Region:
    """Part of a plane, mapped into space.

    outline: signed distance (n,) of plane points (n, 2), negative inside. to_space: (n, 2) -> (n, 3).
    spacing: wanted edge length (n,) at points in space (n, 3). fixed: (k, 2) nodes, which take
    in those on the boundary. box: lower and upper corner. cell: spacing of the lattice that nodes start from.
    """

    outline: Callable[[FloatArray], FloatArray]
    to_space: Callable[[FloatArray], FloatArray]
    spacing: Callable[[FloatArray], FloatArray]
    fixed: FloatArray
    box: tuple[tuple[float, float], tuple[float, float]]
    cell: float


def triangulate(region: Region, seed: int = 0) -> tuple[FloatArray, IntArray]:
    """Nodes (n, 2), the fixed ones first, and counter-clockwise triangles (m, 3)."""
    nodes = np.concatenate([region.fixed, _scattered(region, seed)])
    fixed = len(region.fixed)
    for step in range(STEPS):
        if step % RETRIANGULATE == 0:
            edges = _edges(_triangles(region, nodes))
        nodes[fixed:] += RELAXATION * _pulled_back(region, nodes, edges)[fixed:]
        _return_inside(region, nodes, fixed)
    return nodes, _triangles(region, nodes)


def _scattered(region: Region, seed: int) -> FloatArray:
    """Points of a lattice thinned by chance to the density that the spacing wants."""
    (left, low), (right, high) = region.box
    rows = region.cell * np.sqrt(0.75)
    u, v = np.meshgrid(np.arange(left, right, region.cell), np.arange(low, high, rows))
    u[1::2] += region.cell / 2.0
    nodes = np.column_stack([u.ravel(), v.ravel()])
    nodes = nodes[region.outline(nodes) < -0.1]
    by_u, by_v = _stretch(region, nodes)
    area = np.linalg.norm(np.cross(by_u, by_v), axis=1) * region.cell * rows
    wanted = np.sqrt(0.75) * region.spacing(region.to_space(nodes)) ** 2
    nodes = nodes[np.random.default_rng(seed).random(len(nodes)) < area / wanted]
    near = cKDTree(region.to_space(region.fixed)).query(region.to_space(nodes))[0]
    return nodes[near > 0.6 * region.spacing(region.to_space(nodes))]


def _stretch(region: Region, nodes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Derivatives (n, 3) of the map by u and by v."""
    here = region.to_space(nodes)
    return (
        (region.to_space(nodes + np.array([STENCIL, 0.0])) - here) / STENCIL,
        (region.to_space(nodes + np.array([0.0, STENCIL])) - here) / STENCIL,
    )


def _pulled_back(region: Region, nodes: FloatArray, edges: IntArray) -> FloatArray:
    """Moves (n, 2) by the springs' forces in space, at most LARGEST_MOVE."""
    points = region.to_space(nodes)
    along = points[edges[:, 0]] - points[edges[:, 1]]
    length = np.linalg.norm(along, axis=1)
    wanted = region.spacing(0.5 * (points[edges[:, 0]] + points[edges[:, 1]]))
    wanted = wanted * PRESSURE * np.sqrt((length**2).sum() / (wanted**2).sum())
    force = (np.maximum(wanted - length, 0.0) / length)[:, None] * along
    total = np.zeros_like(points)
    np.add.at(total, edges[:, 0], force)
    np.add.at(total, edges[:, 1], -force)
    by_u, by_v = _stretch(region, nodes)
    uu, uv, vv = (by_u**2).sum(1), (by_u * by_v).sum(1), (by_v**2).sum(1)
    determinant = np.maximum(uu * vv - uv**2, 1e-3)
    fu, fv = (total * by_u).sum(1), (total * by_v).sum(1)
    move = np.column_stack([vv * fu - uv * fv, uu * fv - uv * fu]) / determinant[:, None]
    size = np.linalg.norm(move, axis=1, keepdims=True)
    return move * np.minimum(1.0, LARGEST_MOVE / np.maximum(size, 1e-9))


def _return_inside(region: Region, nodes: FloatArray, fixed: int) -> None:
    """Project nodes that left the region back to its outline."""
    away = region.outline(nodes)
    out = np.flatnonzero(away > 0.0)
    out = out[out >= fixed]
    if len(out):
        _to_outline(region, nodes, out)


def _to_outline(region: Region, nodes: FloatArray, which: IntArray) -> None:
    """Move nodes along the slope of the distance to the outline."""
    step, away = 1e-3, region.outline(nodes[which])
    slope = np.column_stack([(region.outline(nodes[which] + shift) - away) / step for shift in step * np.eye(2)])
    nodes[which] -= away[:, None] * slope / np.maximum((slope**2).sum(1, keepdims=True), 1e-6)


def _triangles(region: Region, nodes: FloatArray) -> IntArray:
    triangles = Delaunay(nodes).simplices.astype(np.int64)
    triangles = triangles[region.outline(nodes[triangles].mean(axis=1)) < INSIDE]
    a, b, c = (nodes[triangles[:, k]] for k in range(3))
    clockwise = _turn(a, b, c) < 0.0
    triangles[clockwise] = triangles[clockwise][:, [0, 2, 1]]
    points = region.to_space(nodes)
    for _ in range(LARGEST_FLIP_SWEEPS):
        if not _flip(triangles, nodes, points):
            break
    return triangles


def _turn(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Twice the signed area of plane triangles."""
    result: FloatArray = (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (
        c[..., 0] - a[..., 0]
    )
    return result


def _edges(triangles: IntArray) -> IntArray:
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def _flip(triangles: IntArray, nodes: FloatArray, points: FloatArray) -> int:
    """Swap diagonals whose opposite angles in space exceed 180 degrees and that are convex in the plane; how many."""
    a, b, left, right, first, second = _diagonals(triangles)
    excess = _angle(points, left, a, b) + _angle(points, right, a, b) - np.pi
    convex = _turn(nodes[left], nodes[right], nodes[a]) * _turn(nodes[left], nodes[right], nodes[b]) < -1e-6
    touched: set[int] = set()
    for k in np.flatnonzero((excess > 1e-6) & convex):
        if first[k] in touched or second[k] in touched:
            continue
        triangles[first[k]] = left[k], a[k], right[k]
        triangles[second[k]] = right[k], b[k], left[k]
        touched |= {first[k], second[k]}
    return len(touched)


def _diagonals(triangles: IntArray) -> tuple[npt.NDArray[np.int64], ...]:
    """Inner edges a -> b of the first triangle, the corners opposite to them, and both triangles."""
    start = triangles.ravel()
    end = triangles[:, [1, 2, 0]].ravel()
    opposite = triangles[:, [2, 0, 1]].ravel()
    owner = np.repeat(np.arange(len(triangles)), 3)
    key = np.minimum(start, end) * (triangles.max() + 1) + np.maximum(start, end)
    order = np.argsort(key, kind="stable")
    twin = np.flatnonzero(key[order][1:] == key[order][:-1])
    one, other = order[twin], order[twin + 1]
    return start[one], end[one], opposite[one], opposite[other], owner[one], owner[other]


def _angle(points: FloatArray, at: IntArray, one: IntArray, other: IntArray) -> FloatArray:
    p, q = points[one] - points[at], points[other] - points[at]
    cosine = (p * q).sum(1) / np.sqrt((p**2).sum(1) * (q**2).sum(1))
    result: FloatArray = np.arccos(np.clip(cosine, -1.0, 1.0))
    return result
