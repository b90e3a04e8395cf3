"""Gaps of all points that may touch teeth or the other lip, without a look at each; nothing is allocated."""

from __future__ import annotations

import numba

from risorius.effects.contact_patches import below, beyond_leaders, leaders_of_others
from risorius.effects.contact_planes import beyond_planes
from risorius.effects.lane_blocks import place_blocks
from risorius.effects.lip_gaps import gaps_to_lips, leave_beside, search_nearest
from risorius.effects.teeth_blocks import beyond_blocks
from risorius.effects.teeth_gaps import APART, gaps_to_teeth

_compiled = numba.njit(cache=True, error_model="numpy")

CLOSE = 1e-3  # metres from the other lip, within which all triangles around the nearest vertex are looked at


@_compiled
def find(x, teeth, lips, of_blocks, patches, groups, around, close, state):  # type: ignore[no-untyped-def]
    """Look at all that may touch, of vertices x (n, 3) that nothing has moved yet.

    close: metres from the other lip within which triangles around the nearest vertex are looked at, whatever leads to.
    """
    at, which, which_lips, gaps, gaps_lips, moved = state[0], state[1], state[2], state[3], state[5], state[9]
    unsure = state[11]
    points, _onset, _away, _grid, _starts, shapes, lows, spacings, moves, least, least_starts, turn, origin = teeth
    places, onsets, turned, cells = of_blocks
    moved[:], gaps[:], unsure[:] = 0.0, APART, False
    _place(x, points, places)
    beyond_blocks(places, onsets, shapes, lows, spacings, moves, least, least_starts, turn, origin, turned, cells, gaps)
    approach(x, teeth, lips, below(0.0, gaps, which), 0, state)
    vertices, facing = lips[0], lips[1]
    order, starts = patches
    at[:] = facing
    _sides, vertices_of_blocks, _split, places_of_blocks, spheres = around
    place_blocks(x, vertices_of_blocks, places_of_blocks, spheres)
    beyond_planes(x, vertices, groups, gaps_lips)
    _look(x, teeth, lips, around, leaders_of_others(order, starts, gaps_lips, which_lips), close, state)
    count = beyond_leaders(x, vertices, order, starts, gaps_lips, unsure, which_lips)
    _look(x, teeth, lips, around, count, close, state)


@_compiled
def find_gaps(x, teeth, lips, around, state):  # type: ignore[no-untyped-def]
    """Find the gaps of all points, whatever bounds tell."""
    at, which, which_lips = state[:3]
    at[:] = lips[1]
    for number in range(len(which)):
        which[number] = number
    for number in range(len(which_lips)):
        which_lips[number] = number
    _sides, vertices_of_blocks, _split, places_of_blocks, spheres = around
    place_blocks(x, vertices_of_blocks, places_of_blocks, spheres)
    approach(x, teeth, lips, len(which), 0, state)
    _look(x, teeth, lips, around, len(which_lips), CLOSE, state)


@_compiled
def approach(x, teeth, lips, count, count_lips, state):  # type: ignore[no-untyped-def]
    """Find the gaps of some of the points, of lips as far as the way downhill leads."""
    points, onset, away, grid, starts, shapes, lows, spacings, moves, least, least_starts, turn, origin = teeth
    vertices, _facing, places, triangles, across, planes, sign, fan_starts, fans = lips
    at, which, which_lips, gaps, ways, gaps_lips, ways_lips, _wanted, _total, _moved, _shifts, unsure, _acting = state
    gaps_to_teeth(
        x, points, which, count, onset, away, grid, starts, shapes, lows, spacings, moves, least, least_starts, turn,
        origin, gaps, ways,
    )  # fmt: skip
    gaps_to_lips(
        x, vertices, which_lips, count_lips, at, places, triangles, across, planes, sign, gaps_lips, ways_lips, unsure
    )  # fmt: skip
    leave_beside(x, vertices, which_lips, count_lips, triangles, fan_starts, fans, sign, gaps_lips, ways_lips, unsure)


@_compiled
def _look(x, teeth, lips, around, count, close, state):  # type: ignore[no-untyped-def]
    """Find the gaps of some points of the lips, to what is nearest wherever the way downhill ends.

    Their numbers are overwritten.
    """
    at, which_lips, gaps_lips = state[0], state[2], state[5]
    approach(x, teeth, lips, 0, count, state)
    nearer = search_nearest(x, lips, around, which_lips, count, close, at, gaps_lips)
    approach(x, teeth, lips, 0, nearer, state)


@_compiled
def _place(x, members, places):  # type: ignore[no-untyped-def]
    """Set places (3, b) of members (b,), one coordinate after the other."""
    xs, ys, zs = places[0], places[1], places[2]
    for i in range(len(members)):
        p = members[i]
        xs[i], ys[i], zs[i] = x[p, 0], x[p, 1], x[p, 2]


@_compiled
def smallest(gaps):  # type: ignore[no-untyped-def]
    """Smallest of gaps (k,), APART where there are none."""
    found = APART
    for gap in gaps:
        found = min(found, gap)
    return found


@_compiled
def deepest(gaps, gaps_lips):  # type: ignore[no-untyped-def]
    """Metres that any point is in anything at the most, negative where none is."""
    return -min(smallest(gaps), smallest(gaps_lips))
