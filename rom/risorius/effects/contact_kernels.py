"""Finding skin that is in teeth or in the other lip, and moving it out; nothing is allocated, nothing is random.

Loops are in functions that call none with arrays: numba would count references to each of them at every call.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from risorius.closest_point import closest_point
from risorius.effects.contact_blocks import BLOCK, beyond_blocks, blocks
from risorius.effects.contact_patches import (
    below,
    beyond_leaders,
    leaders_of_others,
    take_off_shifts,
    take_off_shifts_apart,
)
from risorius.effects.contact_planes import beyond_planes
from risorius.effects.lane_blocks import ROUNDING
from risorius.vector_lanes import LANES
from risorius.vector_masks import first_lane, lanes_within
from risorius.vector_sums import least_squared, most_squared, sum_of_lanes

_compiled = numba.njit(cache=True, error_model="numpy")

SWEEPS = 5  # at most, of a frame
SEARCHED = 4e-3  # metres about a point of a lip
LITTLE, FIRST = 0.2e-3, 2  # metres: no sweep for less after the first ones
ENOUGH = 0.1e-3  # metres: no sweep for less
GAIN = 1.25  # of a sweep, which moves by weighted means and so falls short of the deepest
SHARED = 0.75  # of a depth in the other lip, which gives way, too
SPARE = 0.1e-3  # metres: what is moved out goes so far beyond, for what lies between the points
ASIDE = 0.0  # cosine between the nearest way out of a tooth and that at rest, below which the latter is taken
LONGEST_WAY = 8  # steps along it
SHORTEST_STEP = 0.1e-3  # metres
FAR = 8e-3  # metres between lips that cannot touch
LONGEST_WALK = 16  # triangles
DEEPEST = 4e-3  # metres; what is farther behind a lip is not in it
FARTHEST = 8e-3  # metres: no more is moved in a frame, whatever is wanted
APART = 1.0  # metres: a gap where there is nothing to touch
CLEAR = 1e-3  # metres
CLOSE = 1e-3  # metres from the other lip, within which all triangles around the nearest vertex are looked at
TOLERATED = 0.25e-3  # metres: what is left deeper in anything calls for more
DUBIOUS = 0.6e-3  # metres: what is found deeper may be beside the other lip
ASLANT, OPPOSED = -0.6, -0.9  # cosines of skin with skin that it is behind: more is beside it, less surely in it
A_LANE = np.float32(1 / LANES)


@_compiled
def move_jaw(coordinates, transforms, turn, origin):  # type: ignore[no-untyped-def]
    """Set where the jaw's teeth are, turn (3, 3) @ place + origin (3,): transforms (q, 4, 4) times coordinates (r,)."""
    for i in range(3):
        origin[i] = 0.0
        for j in range(3):
            turn[i, j] = 1.0 if i == j else 0.0
    for k in range(len(transforms)):
        for i in range(3):
            origin[i] += coordinates[k] * transforms[k, i, 3]
            for j in range(3):
                turn[i, j] += coordinates[k] * transforms[k, i, j]


@_compiled
def _linear(c000, c001, c010, c011, c100, c101, c110, c111, u, v, w):  # type: ignore[no-untyped-def]
    """Value at (u, v, w) in a cube between its corners, and derivatives by u, v, w."""
    c00, c01 = c000 + w * (c001 - c000), c010 + w * (c011 - c010)
    c10, c11 = c100 + w * (c101 - c100), c110 + w * (c111 - c110)
    c0, c1 = c00 + v * (c01 - c00), c10 + v * (c11 - c10)
    by_v = (1.0 - u) * (c01 - c00) + u * (c11 - c10)
    w_0 = (1.0 - v) * (c001 - c000) + v * (c011 - c010)
    w_1 = (1.0 - v) * (c101 - c100) + v * (c111 - c110)
    return c0 + u * (c1 - c0), c1 - c0, by_v, (1.0 - u) * w_0 + u * w_1


@_compiled
def gaps_to_teeth(  # type: ignore[no-untyped-def]
    x, points, which, count, onset, away, grid, starts, shapes, lows, spacings, moves, least, least_starts, turn,
    origin, gaps, ways,
):  # fmt: skip
    """Gaps (k,) of `count` of the points, `which` by number, to what is nearest of the obstacles; ways out (k, 3).

    The nearest is not taken where it leads to the other side of a tooth than that at rest. What is CLEAR of all that
    is in its block of the grid, or beyond the grid, is nearer than that block or the grid's rim tells at the most.
    """
    for e in range(count):
        number = which[e]
        p = points[number]
        gaps[number] = APART
        for o in range(len(starts)):
            begins = onset[number, o]
            if not begins > -1.0:
                continue
            a, b, c = float(x[p, 0]), float(x[p, 1]), float(x[p, 2])
            if moves[o]:
                a, b, c = a - origin[0], b - origin[1], c - origin[2]
                a, b, c = (turn[0, 0] * a + turn[1, 0] * b + turn[2, 0] * c,
                           turn[0, 1] * a + turn[1, 1] * b + turn[2, 1] * c,
                           turn[0, 2] * a + turn[1, 2] * b + turn[2, 2] * c)  # fmt: skip
            per_metre = 1.0 / spacings[o]
            a, b, c = (a - lows[o, 0]) * per_metre, (b - lows[o, 1]) * per_metre, (c - lows[o, 2]) * per_metre
            ny, nz = shapes[o, 1], shapes[o, 2]
            ox, oy, oz = away[number, o, 0], away[number, o, 1], away[number, o, 2]
            gap, gx, gy, gz, way = least[len(least) - len(starts) + o] - begins, ox, oy, oz, 0.0
            for step in range(LONGEST_WAY):
                s = way * per_metre
                u, v, w = a + s * ox, b + s * oy, c + s * oz
                if not (0.0 <= u < shapes[o, 0] - 1 and 0.0 <= v < ny - 1 and 0.0 <= w < nz - 1):
                    break
                i, j, k = int(u), int(v), int(w)
                if step == 0:
                    across, along = blocks(shapes[o, 1]), blocks(shapes[o, 2])
                    block = least_starts[o] + ((i // BLOCK) * across + j // BLOCK) * along + k // BLOCK
                    gap = least[block] - begins
                    if gap > CLEAR:
                        break
                n = starts[o] + (i * ny + j) * nz + k
                m = n + ny * nz
                here, hx, hy, hz = _linear(
                    grid[n], grid[n + 1], grid[n + nz], grid[n + nz + 1],
                    grid[m], grid[m + 1], grid[m + nz], grid[m + nz + 1], u - i, v - j, w - k,
                )  # fmt: skip
                here -= begins
                if step == 0:
                    gap = here
                    length = max(math.sqrt(hx * hx + hy * hy + hz * hz), 1e-12)
                    if gap >= 0.0 or hx * ox + hy * oy + hz * oz >= ASIDE * length:
                        gx, gy, gz = hx / length, hy / length, hz / length
                        break
                if here >= 0.0:
                    break
                way += max(-here, SHORTEST_STEP)
            gap = gap if way == 0.0 else -way
            if gap >= gaps[number]:
                continue
            gaps[number] = gap
            if moves[o]:
                for i in range(3):
                    ways[number, i] = turn[i, 0] * gx + turn[i, 1] * gy + turn[i, 2] * gz
            else:
                ways[number, 0], ways[number, 1], ways[number, 2] = gx, gy, gz


@_compiled
def gaps_to_lips(  # type: ignore[no-untyped-def]
    x, vertices, which, count, at, places, triangles, across, planes, sign, gaps, ways, unsure
):
    """Gaps (l,) of `count` of the lips' points, `which` by number, to the other lip; ways out (l, 3), unit vectors.

    The nearest point is found downhill from the triangle `at` (l,), across the edges that it lies on; `at` becomes its
    triangle. There is nothing to touch at the border, far away, and behind what is behind at rest, too: there is
    tissue in between. What is behind the other lip there is unsure (l,): another point may get into it without
    crossing it.
    """
    for e in range(count):
        number = which[e]
        p, t, candidate = vertices[number], at[number], 0
        px, py, pz = x[p, 0], x[p, 1], x[p, 2]
        square, w0, w1, w2, begun = FAR * FAR, 1.0, 0.0, 0.0, False
        for _ in range(LONGEST_WALK):
            following = -1
            for k in range(-1, 3):
                if k < 0:
                    if begun:
                        continue
                    candidate = t
                else:
                    opposite = w2 if k == 0 else (w0 if k == 1 else w1)
                    candidate = across[t, k]
                    if not begun or opposite != 0.0 or candidate < 0:
                        continue
                a, b, c = triangles[candidate, 0], triangles[candidate, 1], triangles[candidate, 2]
                s, v0, v1, v2 = closest_point(
                    px, py, pz, x[a, 0], x[a, 1], x[a, 2], x[b, 0], x[b, 1], x[b, 2], x[c, 0], x[c, 1], x[c, 2]
                )
                if s < square * (1.0 - 1e-6):
                    square, following = s, candidate
                    n0, n1, n2 = v0, v1, v2
            if following < 0:
                break
            t, begun = following, True
            w0, w1, w2 = n0, n1, n2
        gaps[number], unsure[number] = FAR, False
        if not begun:
            continue
        at[number] = t
        gaps[number] = math.sqrt(square)
        ends = False
        for k in range(3):
            opposite = w2 if k == 0 else (w0 if k == 1 else w1)
            ends = ends or (opposite == 0.0 and across[t, k] < 0)
        nx, ny, nz = 0.0, 0.0, 0.0
        for k in range(-1, 3):
            candidate = t
            if k >= 0:
                opposite = w2 if k == 0 else (w0 if k == 1 else w1)
                if opposite != 0.0:
                    continue
                candidate = across[t, k]
                if candidate < 0:
                    continue
            a, b, c = triangles[candidate, 0], triangles[candidate, 1], triangles[candidate, 2]
            ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
            vx, vy, vz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
            mx, my, mz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
            scale = sign / max(math.sqrt(mx * mx + my * my + mz * mz), 1e-20)
            nx, ny, nz = nx + mx * scale, ny + my * scale, nz + mz * scale
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        side = (nx * (px - w0 * x[a, 0] - w1 * x[b, 0] - w2 * x[c, 0])
                + ny * (py - w0 * x[a, 1] - w1 * x[b, 1] - w2 * x[c, 1])
                + nz * (pz - w0 * x[a, 2] - w1 * x[b, 2] - w2 * x[c, 2]))  # fmt: skip
        if side >= 0.0:
            continue
        behind = (planes[t, 0] * places[number, 0] + planes[t, 1] * places[number, 1]
                  + planes[t, 2] * places[number, 2] < planes[t, 3])  # fmt: skip
        if ends or behind or square >= DEEPEST * DEEPEST:
            unsure[number] = True
            continue
        gaps[number] = -gaps[number]
        length = max(math.sqrt(nx * nx + ny * ny + nz * nz), 1e-12)
        ways[number, 0], ways[number, 1], ways[number, 2] = nx / length, ny / length, nz / length


@_compiled
def _leave_beside(  # type: ignore[no-untyped-def]
    x, vertices, which, count, triangles, fan_starts, fans, sign, gaps, ways, unsure
):
    """Tell what is DUBIOUS of `count` of the points by whether it faces what it is behind, as skin that touches does.

    What does not is beside the other lip with nothing to spare, so that a sure look does not pass it over. That is
    unsure (l,), and so is what hardly does. Around a vertex there are triangles `fans` from fan_starts (n + 1,).
    """
    for e in range(count):
        number = which[e]
        if not gaps[number] < -DUBIOUS:
            continue
        nx, ny, nz, vertex = 0.0, 0.0, 0.0, vertices[number]
        for m in range(fan_starts[vertex], fan_starts[vertex + 1]):
            a, b, c = triangles[fans[m], 0], triangles[fans[m], 1], triangles[fans[m], 2]
            ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
            vx, vy, vz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
            nx, ny, nz = nx + uy * vz - uz * vy, ny + uz * vx - ux * vz, nz + ux * vy - uy * vx
        length = math.sqrt(nx * nx + ny * ny + nz * nz)
        along = sign * (nx * ways[number, 0] + ny * ways[number, 1] + nz * ways[number, 2])
        unsure[number] = along > OPPOSED * length
        if along > ASLANT * length:
            gaps[number] = 0.0


@_compiled
def smallest(gaps):  # type: ignore[no-untyped-def]
    """Smallest of gaps (k,), APART where there are none."""
    found = APART
    for gap in gaps:
        found = min(found, gap)
    return found


@_compiled
def gather(vertices, gaps, ways, factor, starts, controls, shares, wanted, total):  # type: ignore[no-untyped-def]
    """Add what points with a negative gap want of the controls, weighted by depth."""
    for number in range(len(vertices)):
        depth = -gaps[number]
        if depth <= 0.0:
            continue
        depth = factor * (depth + SPARE)
        dx, dy, dz = depth * ways[number, 0], depth * ways[number, 1], depth * ways[number, 2]
        p = vertices[number]
        for entry in range(starts[p], starts[p + 1]):
            share, control = shares[entry] * depth, controls[entry]
            total[control] += share
            wanted[control, 0] += share * dx
            wanted[control, 1] += share * dy
            wanted[control, 2] += share * dz


@_compiled
def move(x, wanted, total, moved, shifts, acting, starts, vertices, shares):  # type: ignore[no-untyped-def]
    """Move the vertices by what is wanted of the controls in the mean, up to FARTHEST in all; nothing is wanted then.

    moved (c, 3): by how much the controls have moved in this frame; shifts (n, 3): the vertices now, by those that are
    acting (c,), zero elsewhere. Returns metres that any vertex has moved now at the most.
    """
    for control in range(len(acting)):
        if acting[control]:
            for entry in range(starts[control], starts[control + 1]):
                vertex = vertices[entry]
                shifts[vertex, 0], shifts[vertex, 1], shifts[vertex, 2] = 0.0, 0.0, 0.0
        acting[control] = total[control] > 0.0
    for control in range(len(acting)):
        if not acting[control]:
            continue
        scale = GAIN / total[control]
        dx, dy, dz = wanted[control, 0] * scale, wanted[control, 1] * scale, wanted[control, 2] * scale
        wanted[control, 0], wanted[control, 1], wanted[control, 2], total[control] = 0.0, 0.0, 0.0, 0.0
        ax, ay, az = moved[control, 0] + dx, moved[control, 1] + dy, moved[control, 2] + dz
        short = min(1.0, FARTHEST / max(math.sqrt(ax * ax + ay * ay + az * az), 1e-12))
        dx, dy, dz = short * ax - moved[control, 0], short * ay - moved[control, 1], short * az - moved[control, 2]
        moved[control, 0], moved[control, 1], moved[control, 2] = short * ax, short * ay, short * az
        for entry in range(starts[control], starts[control + 1]):
            vertex, share = vertices[entry], shares[entry]
            a, b, c = share * dx, share * dy, share * dz
            shifts[vertex, 0] += a
            shifts[vertex, 1] += b
            shifts[vertex, 2] += c
            x[vertex, 0] += a
            x[vertex, 1] += b
            x[vertex, 2] += c
    square = 0.0
    for control in range(len(acting)):
        if acting[control]:
            for entry in range(starts[control], starts[control + 1]):
                vertex = vertices[entry]
                a, b, c = shifts[vertex, 0], shifts[vertex, 1], shifts[vertex, 2]
                square = max(square, a * a + b * b + c * c)
    return math.sqrt(square)


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
    _approach(x, teeth, lips, below(0.0, gaps, which), 0, state)
    vertices, facing = lips[0], lips[1]
    order, starts = patches
    at[:] = facing
    _place_blocks(x, around[1], around[3], around[4])
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
    _place_blocks(x, around[1], around[3], around[4])
    _approach(x, teeth, lips, len(which), 0, state)
    _look(x, teeth, lips, around, len(which_lips), CLOSE, state)


@_compiled
def _approach(x, teeth, lips, count, count_lips, state):  # type: ignore[no-untyped-def]
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
    _leave_beside(x, vertices, which_lips, count_lips, triangles, fan_starts, fans, sign, gaps_lips, ways_lips, unsure)


@_compiled
def _look(x, teeth, lips, around, count, close, state):  # type: ignore[no-untyped-def]
    """Find the gaps of some points of the lips, to what is nearest wherever the way downhill ends.

    Their numbers are overwritten.
    """
    at, which_lips, gaps_lips = state[0], state[2], state[5]
    _approach(x, teeth, lips, 0, count, state)
    nearer = _search(x, lips, around, which_lips, count, close, at, gaps_lips)
    _approach(x, teeth, lips, 0, nearer, state)


@_compiled
def _place(x, members, places):  # type: ignore[no-untyped-def]
    """Set places (3, b) of members (b,), one coordinate after the other."""
    xs, ys, zs = places[0], places[1], places[2]
    for i in range(len(members)):
        p = members[i]
        xs[i], ys[i], zs[i] = x[p, 0], x[p, 1], x[p, 2]


@_compiled
def _place_blocks(x, members, places, spheres):  # type: ignore[no-untyped-def]
    """Set places (3, b * LANES) of members (b, LANES), and spheres (4, b) about each block that has any."""
    xs, ys, zs, radii = places[0], places[1], places[2], spheres[3]
    for block in range(len(members)):
        if members[block, 0] < 0:
            continue
        start = LANES * block
        for m in range(LANES):
            p = members[block, m]
            xs[start + m], ys[start + m], zs[start + m] = x[p, 0], x[p, 1], x[p, 2]
        a, b, c = (sum_of_lanes(xs, start) * A_LANE, sum_of_lanes(ys, start) * A_LANE, sum_of_lanes(zs, start) * A_LANE)
        spheres[0, block], spheres[1, block], spheres[2, block] = a, b, c
        radii[block] = math.sqrt(most_squared(xs, ys, zs, start, a, b, c)) + ROUNDING


@_compiled
def _search(x, lips, around, which, count, close, at, gaps):  # type: ignore[no-untyped-def]
    """Set `at` (l,) to a triangle at the nearest vertex around a point where that is nearer than the gap (l,) found.

    Of `count` of the points, `which` by number, keeps those for which it is; returns how many. Where the gap is at most
    `close`, triangles around the nearest vertex are compared even if one of them was found.
    """
    vertices, triangles, fan_starts, fans = lips[0], lips[3], lips[7], lips[8]
    sides, members, split, places, spheres = around
    xs, ys, zs = places[0], places[1], places[2]
    sx, sy, sz, radii = spheres[0], spheres[1], spheres[2], spheres[3]
    found = 0
    for e in range(count):
        number = which[e]
        if abs(gaps[number]) < TOLERATED:
            continue
        p, closest, nearest, least = vertices[number], -1, -1, np.float32(SEARCHED * SEARCHED)
        px, py, pz = x[p, 0], x[p, 1], x[p, 2]
        for k in range(3):
            q = triangles[at[number], k]
            u, v, w = px - x[q, 0], py - x[q, 1], pz - x[q, 2]
            square = u * u + v * v + w * w
            if square < least:
                least, nearest = square, q
        least *= np.float32(1.0 - 1e-6)
        first, last = (split, len(members)) if sides[number] == 0 else (0, split)
        for start in range(first, last, LANES):
            within = lanes_within(sx, sy, sz, radii, start, px, py, pz, math.sqrt(least))
            while within != 0:
                block = start + first_lane(within)
                within &= within - 1
                square = least_squared(xs, ys, zs, LANES * block, px, py, pz)
                if square < least:
                    closest, least = block, square
        gaps[number] = min(gaps[number], SEARCHED)
        if closest >= 0:
            for m in range(LANES):
                k = LANES * closest + m
                u, v, w = px - xs[k], py - ys[k], pz - zs[k]
                if u * u + v * v + w * w <= least:
                    nearest = members[closest, m]
                    break
        elif gaps[number] > close:
            continue
        if nearest < 0:
            continue
        least, begun = gaps[number] * gaps[number] * (1.0 - 1e-6), at[number]
        for m in range(fan_starts[nearest], fan_starts[nearest + 1]):
            t = fans[m]
            a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            square = closest_point(
                px, py, pz, x[a, 0], x[a, 1], x[a, 2], x[b, 0], x[b, 1], x[b, 2], x[c, 0], x[c, 1], x[c, 2]
            )[0]
            if square < least:
                least, at[number] = square, t
        if at[number] != begun:
            which[found] = number
            found += 1
    return found


@_compiled
def deepest(gaps, gaps_lips):  # type: ignore[no-untyped-def]
    """Metres that any point is in anything at the most, negative where none is."""
    return -min(smallest(gaps), smallest(gaps_lips))


@_compiled
def sweep(x, teeth, lips, rows, columns, state):  # type: ignore[no-untyped-def]
    """Move vertices x (n, 3) out of what the last look has found."""
    at, which, which_lips, gaps, ways, gaps_lips, ways_lips, wanted, total, moved, shifts, _unsure, acting = state
    for number in range(SWEEPS):
        if deepest(gaps, gaps_lips) < (ENOUGH if number < FIRST else LITTLE):
            break
        gather(teeth[0], gaps, ways, 1.0, rows[0], rows[1], rows[2], wanted, total)
        gather(lips[0], gaps_lips, ways_lips, SHARED, rows[0], rows[1], rows[2], wanted, total)
        farthest = move(x, wanted, total, moved, shifts, acting, columns[0], columns[1], columns[2])
        take_off_shifts(teeth[0], shifts, farthest, gaps)
        take_off_shifts_apart(lips[0], lips[3], at, shifts, farthest, gaps_lips)
        count, count_lips = below(0.0, gaps, which), below(0.0, gaps_lips, which_lips)
        _approach(x, teeth, lips, count, count_lips, state)


@_compiled
def adopt(proven, doubted, proof, state):  # type: ignore[no-untyped-def]
    """Take over what a look that makes sure tells of the points (l,) of the lips that are doubted, by their numbers.

    proven (l,): numbers among the points that it looks at, whose flags are doubted, and of which proof holds triangles
    that they are at, gaps, ways out.
    """
    at, gaps_lips, ways_lips = state[0], state[5], state[6]
    at_proven, _space, gaps_proven, ways_proven = proof
    for number in range(len(proven)):
        k = proven[number]
        if gaps_proven[k] < 0.0:
            at[number], gaps_lips[number] = at_proven[k], gaps_proven[k]
            for i in range(3):
                ways_lips[number, i] = ways_proven[k, i]
        elif doubted[k]:
            gaps_lips[number] = abs(gaps_lips[number])
