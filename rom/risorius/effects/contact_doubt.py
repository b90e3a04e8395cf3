"""Where a quick look at the lips cannot be trusted: at what sweeps have moved or tissue has folded, and close to that.

Sweeps follow triangles that were nearest before them; what they move passes others.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from risorius.effects.contact_patches import surround
from risorius.effects.lip_gaps import DEEPEST, TOLERATED
from risorius.vector_lanes import LANES
from risorius.vector_masks import first_lane, lanes_within
from risorius.vector_sums import least_squared

_compiled = numba.njit(cache=True, error_model="numpy")

MOVED = 0.15e-3  # metres: points that have moved by less, all of them, have come less than 0.3 mm closer
AROUND_FOLDS = 8e-3  # metres at rest
CLOSE = 1e-3  # metres: between a point and the other lip
TRUSTED, AT_WORK, BESIDE = range(3)  # where a point is: far from all that, where it happens, close to that


@_compiled
def _doubt_moved(x, before, points, order, starts, most, doubted):  # type: ignore[no-untyped-def]
    """Doubt points that are farther than MOVED from where they were before (l, 3); most (g,): of patches, how far."""
    for patch in range(len(starts) - 1):
        farthest = np.float32(0.0)
        for e in range(starts[patch], starts[patch + 1]):
            number = order[e]
            p = points[number]
            u, v, w = x[p, 0] - before[number, 0], x[p, 1] - before[number, 1], x[p, 2] - before[number, 2]
            square = u * u + v * v + w * w
            farthest = max(farthest, square)
            if square > MOVED * MOVED:
                doubted[number] = AT_WORK
        most[patch] = math.sqrt(farthest)


@_compiled
def _doubt_folded(folds, rest, points, order, starts, spheres, doubted):  # type: ignore[no-untyped-def]
    """Doubt points within AROUND_FOLDS of folds (f, 3), all at rest."""
    xs, ys, zs, radii = spheres[0], spheres[1], spheres[2], spheres[3]
    for f in range(len(folds)):
        x, y, z = np.float32(folds[f, 0]), np.float32(folds[f, 1]), np.float32(folds[f, 2])
        for start in range(0, len(starts) - 1, LANES):
            within = lanes_within(xs, ys, zs, radii, start, x, y, z, np.float32(AROUND_FOLDS))
            while within != 0:
                patch = start + first_lane(within)
                within &= within - 1
                for e in range(starts[patch], starts[patch + 1]):
                    p = points[order[e]]
                    u, v, w = rest[p, 0] - x, rest[p, 1] - y, rest[p, 2] - z
                    if u * u + v * v + w * w < AROUND_FOLDS * AROUND_FOLDS:
                        doubted[order[e]] = AT_WORK


@_compiled
def _doubt_close(x, points, order, starts, split, spheres, moved, places, doubted):  # type: ignore[no-untyped-def]
    """Doubt points on the other lip that those AT_WORK may have come to lie around: within CLOSE, and what they moved.

    moved (g,): by how much points of patches have at the most. places (3, m): working space.
    """
    xs, ys, zs, radii = spheres[0], spheres[1], spheres[2], spheres[3]
    count = len(starts) - 1
    for patch in range(count):
        found = _gather(x, points, order, starts[patch], starts[patch + 1], doubted, places)
        if found == 0:
            continue
        first, last = (split, count) if patch < split else (0, split)
        close = np.float32(min(CLOSE + moved[patch], DEEPEST))
        reach = radii[patch] + close
        for start in range(first, last, LANES):
            within = lanes_within(xs, ys, zs, radii, start, xs[patch], ys[patch], zs[patch], reach)
            while within != 0:
                near = start + first_lane(within)
                within &= within - 1
                if near < last:
                    _doubt_beside(x, points, order, starts[near], starts[near + 1], places, found, close, doubted)


@_compiled
def _gather(x, points, order, begin, end, doubted, places):  # type: ignore[no-untyped-def]
    """Write where those of points order[begin:end] are that are AT_WORK, up to whole LANES; return how many."""
    xs, ys, zs = places[0], places[1], places[2]
    found = 0
    for e in range(begin, end):
        if doubted[order[e]] == AT_WORK:
            p = points[order[e]]
            xs[found], ys[found], zs[found] = x[p, 0], x[p, 1], x[p, 2]
            found += 1
    whole = -(-found // LANES) * LANES
    for k in range(found, whole):
        xs[k], ys[k], zs[k] = xs[0], ys[0], zs[0]
    return whole


@_compiled
def _doubt_beside(x, points, order, begin, end, places, count, close, doubted):  # type: ignore[no-untyped-def]
    """Doubt points order[begin:end] within close of any of `count` places."""
    xs, ys, zs = places[0], places[1], places[2]
    for e in range(begin, end):
        if doubted[order[e]] != TRUSTED:
            continue
        p = points[order[e]]
        for start in range(0, count, LANES):
            if least_squared(xs, ys, zs, start, x[p, 0], x[p, 1], x[p, 2]) < close * close:
                doubted[order[e]] = BESIDE
                break


@_compiled
def doubt(  # type: ignore[no-untyped-def]
    x, before, rest, gaps, unsure, proven, folds, points, patches, spheres, at_rest, work, doubted
):
    """Set which of the points (l,) of the lips are doubted; return whether any is.

    x, rest (n, 3): vertices, of which points are (l,), before (l, 3) sweeps moved them. gaps (k,): that sweeps have
    left, of which some are unsure (k,): what is so, and close to the other lip, may be in it. proven (l,): gaps of all
    points that were proven before them. folds (f, 3): places at rest where tissue was folded. patches: of points, those
    of one lip first, how many these are, and which points the gaps are of. spheres, at_rest (4, g + LANES): about
    patches.
    """
    order, starts, split, looked_at = patches
    most, places = work
    doubted[:] = TRUSTED
    _doubt_moved(x, before, points, order, starts, most, doubted)
    for number in range(len(gaps)):
        if gaps[number] < -TOLERATED:
            doubted[looked_at[number]] = AT_WORK
        elif unsure[number] and gaps[number] < CLOSE and doubted[looked_at[number]] == TRUSTED:
            doubted[looked_at[number]] = BESIDE
    for number in range(len(proven)):
        if proven[number] < -TOLERATED:
            doubted[number] = AT_WORK
    _doubt_folded(folds, rest, points, order, starts, at_rest, doubted)
    found = False
    for flag in doubted:
        found = found or flag != TRUSTED
    if found:
        surround(x, points, order, starts, spheres)
        _doubt_close(x, points, order, starts, split, spheres, most, places, doubted)
    return found


@_compiled
def trust_others(doubted, clear, gaps):  # type: ignore[no-untyped-def]
    """Set gaps (l,) of points that are not doubted to `clear`, of the others to 0."""
    for number in range(len(gaps)):
        gaps[number] = clear if doubted[number] == TRUSTED else 0.0
