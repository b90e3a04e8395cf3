"""Patches of points that may touch, so that most are known to be clear without a look at each.

A gap changes by no more than a point moves: what is as far from the leader of its patch as that is from everything
touches nothing, and neither does what has moved less than its gap since it was looked at.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

_compiled = numba.njit(cache=True, error_model="numpy")
Numbers = npt.NDArray[np.int32]


@dataclass(frozen=True)
class Patches:
    """order (k,): numbers of points, patch after patch, its leader first; starts (g + 1,) of the patches therein."""

    order: Numbers
    starts: Numbers

    @classmethod
    def of(cls, rows: sp.csr_matrix, kinds: npt.NDArray[np.integer]) -> Patches:
        """Patches of points with shares (k, c) in controls: of one of kinds (k,), around one control each."""
        shares = np.pad(rows.toarray(), ((0, 0), (0, 1)))  # so that there is a control at least
        nearest = shares.argmax(axis=1)
        order = np.lexsort((-shares.max(axis=1), nearest, kinds)).astype(np.int32)
        begins = np.flatnonzero(np.diff(kinds[order], prepend=-1) | np.diff(nearest[order], prepend=-1))
        starts = np.append(begins, len(order)).astype(np.int32)
        return cls(order, starts)

    @property
    def leaders(self) -> Numbers:
        """(g,) numbers of the leaders."""
        return self.order[self.starts[:-1]]


@_compiled
def leaders_of_others(order, starts, gaps, which):  # type: ignore[no-untyped-def]
    """Write numbers of the leaders of points whose gaps (k,) are not known to be more than 0; return how many."""
    found = 0
    for patch in range(len(starts) - 1):
        for e in range(starts[patch], starts[patch + 1]):
            if not gaps[order[e]] > 0.0:
                which[found] = order[starts[patch]]
                found += 1
                break
    return found


@_compiled
def beyond_leaders(x, points, order, starts, gaps, unsure, which):  # type: ignore[no-untyped-def]
    """Set gaps (k,) that are not known to be more than 0 to what those of leaders leave; write numbers of the others.

    Leaders that are unsure (k,) leave nothing. Returns how many may touch.
    """
    found = 0
    for patch in range(len(starts) - 1):
        leader = order[starts[patch]]
        p, known = points[leader], 0.0 if unsure[leader] else gaps[leader]
        for e in range(starts[patch] + 1, starts[patch + 1]):
            number = order[e]
            if gaps[number] > 0.0:
                continue
            left = -1.0
            if known > 0.0:
                q = points[number]
                a, b, c = x[q, 0] - x[p, 0], x[q, 1] - x[p, 1], x[q, 2] - x[p, 2]
                square = a * a + b * b + c * c
                if square < known * known:
                    left = known - math.sqrt(square)
            if left > 0.0:
                gaps[number] = left
            else:
                which[found] = number
                found += 1
    return found


@_compiled
def take_off_shifts(points, shifts, farthest, gaps):  # type: ignore[no-untyped-def]
    """Take off gaps (k,) by how much the points have moved, shifts (n, 3), none farther than `farthest`."""
    for number in range(len(points)):
        if gaps[number] > 4.0 * farthest:
            gaps[number] -= farthest
            continue
        p = points[number]
        a, b, c = shifts[p, 0], shifts[p, 1], shifts[p, 2]
        square = a * a + b * b + c * c
        if square > 0.0:
            gaps[number] -= math.sqrt(square)


@_compiled
def take_off_shifts_apart(points, triangles, at, shifts, farthest, gaps):  # type: ignore[no-untyped-def]
    """Take off gaps (k,) by how much the points and the triangles `at` (k,) may have come closer, shifts (n, 3)."""
    for number in range(len(points)):
        if gaps[number] > 4.0 * farthest:
            gaps[number] -= 2.0 * farthest
            continue
        p, t, square = points[number], at[number], 0.0
        for k in range(3):
            q = triangles[t, k]
            a, b, c = shifts[p, 0] - shifts[q, 0], shifts[p, 1] - shifts[q, 1], shifts[p, 2] - shifts[q, 2]
            square = max(square, a * a + b * b + c * c)
        if square > 0.0:
            gaps[number] -= math.sqrt(square)


@_compiled
def below(limit, gaps, which):  # type: ignore[no-untyped-def]
    """Write the numbers of gaps (k,) that are smaller than a limit; return how many."""
    found = 0
    for number in range(len(gaps)):
        if gaps[number] < limit:
            which[found] = number
            found += 1
    return found


@_compiled
def surround(x, vertices, order, starts, spheres):  # type: ignore[no-untyped-def]
    """Set spheres (4, g) about patches of vertices (l,): places of their leaders, and how far their points are off."""
    xs, ys, zs, radii = spheres[0], spheres[1], spheres[2], spheres[3]
    for patch in range(len(starts) - 1):
        o, square = vertices[order[starts[patch]]], np.float32(0.0)
        for e in range(starts[patch] + 1, starts[patch + 1]):
            p = vertices[order[e]]
            u, v, w = x[p, 0] - x[o, 0], x[p, 1] - x[o, 1], x[p, 2] - x[o, 2]
            square = max(square, u * u + v * v + w * w)
        xs[patch], ys[patch], zs[patch], radii[patch] = x[o, 0], x[o, 1], x[o, 2], math.sqrt(square)
