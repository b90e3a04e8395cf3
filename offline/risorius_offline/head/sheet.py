"""The triangulated sheet of the face in its chart, both halves mirror images."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from scipy.interpolate import RegularGridInterpolator
from scipy.spatial import cKDTree

from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray
from risorius_offline.head import chart
from risorius_offline.head.openings import lid_margins, lip_lines
from risorius_offline.head.skin import SKIN
from risorius_offline.head.triangulation import Region, triangulate

Map: TypeAlias = Callable[[FloatArray], FloatArray]

LOWER, UPPER = (0.0, -158.0), (116.0, 92.0)
ROUNDING_BELOW, ROUNDING_ABOVE = 64.0, 50.0  # radii of the rim's corners, millimetres
LATTICE = 1.6


@dataclass(frozen=True)
class Sheet:
    """uv (n, 2), counter-clockwise triangles (m, 3) seen from outside."""

    uv: FloatArray
    triangles: IntArray


def face_sheet(size: float) -> Sheet:
    """Triangulate the chart; `size` multiplies all edge lengths, which are 2 mm at the lips and 7 mm far away."""
    to_space = _surface()
    upper, lower = (chart.coordinates(line) for line in lip_lines())
    mouth = np.concatenate([upper, lower[-2::-1]])
    eye = np.concatenate([chart.coordinates(line)[:-1] for line in _around(lid_margins())])
    at_lips, at_lids = cKDTree(to_space(mouth)), cKDTree(to_space(eye))

    def spacing(points: FloatArray) -> FloatArray:
        lips, lids = at_lips.query(points)[0], at_lids.query(points)[0]
        nose = np.linalg.norm(points - np.array([0.0, -15.0, 100.0]), axis=1)
        wanted = np.minimum.reduce([1.9 + 0.10 * lips, 2.0 + 0.13 * lids, 2.8 + 0.07 * nose, np.full(len(points), 8.5)])
        result: FloatArray = size * wanted
        return result

    hole_mouth = np.concatenate([mouth, [[-1.0, mouth[-1, 1]], [-1.0, mouth[0, 1]]]])

    def outline(uv: FloatArray) -> FloatArray:
        holes = [-_signed_distance(uv, eye), -_signed_distance(uv, hole_mouth)]
        result: FloatArray = np.maximum.reduce([rim(uv), -uv[:, 0], *holes])
        return result

    def walk(line: FloatArray) -> FloatArray:
        return _evenly(line, to_space, spacing)

    fixed = np.concatenate([
        walk(upper), walk(lower)[:-1],
        *(walk(chart.coordinates(line))[:-1] for line in _around(lid_margins())),
        walk(_midline(mouth[0, 1], UPPER[1]))[1:], walk(_midline(mouth[-1, 1], LOWER[1]))[1:],
        walk(_rim_line())[1:-1],
    ])  # fmt: skip
    region = Region(outline, to_space, spacing, fixed, (LOWER, UPPER), 1.4 * size)
    return _mirrored(*triangulate(region))


def rim(uv: FloatArray) -> FloatArray:
    """Signed distance (n,) to the rim of the sheet, negative inside: a rectangle with rounded corners."""
    rounding = np.where(uv[:, 1] < 0.0, ROUNDING_BELOW, ROUNDING_ABOVE)
    aside = np.abs(uv[:, 0]) - UPPER[0] + rounding
    middle, half = 0.5 * (UPPER[1] + LOWER[1]), 0.5 * (UPPER[1] - LOWER[1])
    up = np.abs(uv[:, 1] - middle) - half + rounding
    outside = np.hypot(np.maximum(aside, 0.0), np.maximum(up, 0.0))
    result: FloatArray = outside + np.minimum(np.maximum(aside, up), 0.0) - rounding
    return result


def _rim_line(count: int = 500) -> FloatArray:
    """Left half of the rim, from its lower to its upper end at the midline, to a tenth of a micrometre."""
    turn = np.linspace(0.0, np.pi / 2.0, count)[:, None]
    across, along = np.array([1.0, 0.0]), np.array([0.0, 1.0])
    below = np.array([UPPER[0] - ROUNDING_BELOW, LOWER[1] + ROUNDING_BELOW])
    above = np.array([UPPER[0] - ROUNDING_ABOVE, UPPER[1] - ROUNDING_ABOVE])
    corner = [
        below + ROUNDING_BELOW * (np.sin(turn) * across - np.cos(turn) * along),
        above + ROUNDING_ABOVE * (np.cos(turn) * across + np.sin(turn) * along),
    ]
    sides = np.linspace(corner[0][-1], corner[1][0], count)[1:-1]
    ends = [np.linspace([0.0, end[1]], end, count) for end in (corner[0][0], corner[1][-1])]
    return np.concatenate([ends[0][:-1], corner[0], sides, corner[1], ends[1][-2::-1]])


def _around(margins: tuple[FloatArray, FloatArray]) -> tuple[FloatArray, FloatArray]:
    upper, lower = margins
    return upper, lower[::-1]


def _surface() -> Map:
    """Map of the chart onto the skin, by interpolated distances along the rays."""
    u = np.arange(0.0, UPPER[0] + LATTICE, LATTICE)
    v = np.arange(LOWER[1] - LATTICE, UPPER[1] + LATTICE, LATTICE)
    lattice = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
    depth = RegularGridInterpolator(
        (u, v), chart.outermost(SKIN, lattice).reshape(len(u), len(v)), bounds_error=False, fill_value=None
    )

    def to_space(uv: FloatArray) -> FloatArray:
        origins, directions = chart.rays(uv)
        result: FloatArray = origins + depth(np.column_stack([np.abs(uv[:, 0]), uv[:, 1]]))[:, None] * directions
        return result

    return to_space


def _midline(start: float, end: float) -> FloatArray:
    v = np.linspace(start, end, 400)
    return np.column_stack([np.zeros_like(v), v])


def _evenly(line: FloatArray, to_space: Map, spacing: Map) -> FloatArray:
    """Points (k, 2) on a line, both ends included, spaced in space as wanted."""
    points = to_space(line)
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    passed = np.concatenate([[0.0], np.cumsum(length / spacing(0.5 * (points[1:] + points[:-1])))])
    at = np.linspace(0.0, passed[-1], max(round(passed[-1]), 2) + 1)
    return np.column_stack([np.interp(at, passed, line[:, k]) for k in (0, 1)])


def _signed_distance(points: FloatArray, polygon: FloatArray) -> FloatArray:
    """Distance (n,) to a closed polygon, negative inside."""
    result = np.full(len(points), np.inf)
    inside = np.zeros(len(points), dtype=bool)
    for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        edge, from_a = b - a, points - a
        along = np.clip((from_a @ edge) / max(float(edge @ edge), 1e-30), 0.0, 1.0)
        result = np.minimum(result, np.linalg.norm(from_a - along[:, None] * edge, axis=1))
        # Edges that a ray towards greater u crosses: an odd number of them from within.
        crossed = (a[1] <= points[:, 1]) != (b[1] <= points[:, 1])
        beyond = edge[0] * from_a[:, 1] - edge[1] * from_a[:, 0]
        inside ^= crossed & ((beyond > 0.0) == (edge[1] > 0.0))
    return np.where(inside, -result, result)


def _mirrored(nodes: FloatArray, triangles: IntArray) -> Sheet:
    used = np.unique(triangles)
    number = np.full(len(nodes), -1)
    number[used] = np.arange(len(used))
    nodes, triangles = nodes[used], number[triangles]
    nodes[np.abs(nodes[:, 0]) < 1e-5, 0] = 0.0
    off = np.flatnonzero(nodes[:, 0] > 0.0)
    mirror = np.arange(len(nodes))
    mirror[off] = len(nodes) + np.arange(len(off))
    uv = np.concatenate([nodes, nodes[off] * [-1.0, 1.0]])
    return Sheet(uv, np.concatenate([triangles, mirror[triangles][:, [0, 2, 1]]]))
