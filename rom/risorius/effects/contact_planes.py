"""Which points of the lips planes tell to be clear of the other lip (`contact_groups`); it only ever bounds."""

from __future__ import annotations

import math

import numba
import numpy as np

from risorius.vector_lanes import LANES
from risorius.vector_sums import least_product, most_squared

SURE = 1e-6  # metres: less does not tell hulls apart in single precision
TOLD = 1e-3  # metres: the most that a bound tells

_compiled = numba.njit(cache=True, error_model="numpy")


@_compiled
def beyond_planes(x, vertices, groups, gaps):  # type: ignore[no-untyped-def]
    """Set gaps (l,) of the lips' points to what planes leave, 0 where they tell nothing."""
    (members, starts, split, middles, radii, planes, plane_of, point_starts, points, others, placed, centres, sizes,
     told, meeting) = groups  # fmt: skip
    px, py, pz = placed[0], placed[1], placed[2]
    for i in range(len(members)):
        vertex = members[i]
        px[i], py[i], pz[i] = x[vertex, 0], x[vertex, 1], x[vertex, 2]
    for group in range(len(sizes)):
        first, square = starts[group], np.float32(0.0)
        a, b, c = px[first], py[first], pz[first]
        for i in range(first, starts[group + 1], LANES):
            square = max(square, most_squared(px, py, pz, i, a, b, c))
        centres[0, group], centres[1, group], centres[2, group] = a, b, c
        sizes[group], told[group] = math.sqrt(square), TOLD
    _meet(split, middles, radii, centres, sizes, meeting)
    for number in range(len(gaps)):
        gaps[number] = TOLD
    for a in range(split):
        for column in range(meeting.shape[1]):
            if not meeting[a, column] > 0.0:
                continue
            b, plane = split + column, plane_of[a, column]
            if plane < 0:
                told[a], told[b] = np.float32(0.0), np.float32(0.0)
                continue
            u, v, w = planes[plane, 0], planes[plane, 1], planes[plane, 2]
            lowest, highest = np.float32(np.inf), np.float32(-np.inf)
            for i in range(starts[a], starts[a + 1], LANES):
                lowest = min(lowest, least_product(px, py, pz, i, u, v, w))
            for i in range(starts[b], starts[b + 1], LANES):
                highest = max(highest, -least_product(px, py, pz, i, -u, -v, -w))
            apart = lowest - highest
            if apart > SURE:
                told[a], told[b] = min(told[a], apart), min(told[b], apart)
                continue
            for k in range(point_starts[a], point_starts[a + 1]):
                number = points[k]
                p = vertices[number]
                beyond = u * x[p, 0] + v * x[p, 1] + w * x[p, 2] - highest
                gaps[number] = min(gaps[number], beyond)
            for k in range(point_starts[b], point_starts[b + 1]):
                number = points[k]
                p = vertices[number]
                beyond = lowest - u * x[p, 0] - v * x[p, 1] - w * x[p, 2]
                gaps[number] = min(gaps[number], beyond)
    for group in range(len(told)):
        for k in range(point_starts[group], point_starts[group + 1]):
            number = points[k]
            gap = min(gaps[number], told[group])
            gaps[number] = gap if gap > SURE else 0.0
    for number in others:
        gaps[number] = 0.0


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _meet(split, middles, radii, centres, sizes, meeting):  # type: ignore[no-untyped-def]
    """Set (split, g - split) to more than 0 where spheres of groups of either side meet on the way from rest.

    Where they come within TOLD of each other, that is; on the way they are as large as the larger of rest and now.
    """
    x0, y0, z0, r0 = middles[0, split:], middles[1, split:], middles[2, split:], radii[split:]
    x1, y1, z1, r1 = centres[0, split:], centres[1, split:], centres[2, split:], sizes[split:]
    for a in range(split):
        ax, ay, az, mine = middles[0, a], middles[1, a], middles[2, a], max(radii[a], sizes[a]) + np.float32(TOLD)
        bx, by, bz = centres[0, a], centres[1, a], centres[2, a]
        row = meeting[a]
        for k in range(len(row)):
            x, y, z = ax - x0[k], ay - y0[k], az - z0[k]
            u, v, w = bx - x1[k] - x, by - y1[k] - y, bz - z1[k] - z
            share = -(x * u + y * v + z * w) / max(u * u + v * v + w * w, np.float32(1e-20))
            share = min(max(share, np.float32(0.0)), np.float32(1.0))
            x, y, z = x + share * u, y + share * v, z + share * w
            reach = mine + max(r0[k], r1[k])
            row[k] = reach * reach - (x * x + y * y + z * z)
