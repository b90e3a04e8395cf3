"""How far points of a lip are from the other, and which way out of it; nothing is allocated.

Loops over many points call nothing with arrays: numba would count references to each of them at every call.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from risorius.closest_point import closest_point
from risorius.normals import fan_normal
from risorius.vector_lanes import LANES
from risorius.vector_masks import first_lane, lanes_within
from risorius.vector_sums import least_squared

_compiled = numba.njit(cache=True, error_model="numpy")

SEARCHED = 4e-3  # metres about a point of a lip
FAR = 8e-3  # metres between lips that cannot touch
LONGEST_WALK = 16  # triangles
DEEPEST = 4e-3  # metres; what is farther behind a lip is not in it
TOLERATED = 0.25e-3  # metres: what is left deeper in anything calls for more
DUBIOUS = 0.6e-3  # metres: what is found deeper may be beside the other lip
ASLANT, OPPOSED = -0.6, -0.9  # cosines of skin with skin that it is behind: more is beside it, less surely in it


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
def leave_beside(  # type: ignore[no-untyped-def]
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
        nx, ny, nz = fan_normal(x, vertices[number], fan_starts, fans, triangles)
        length = math.sqrt(nx * nx + ny * ny + nz * nz)
        along = sign * (nx * ways[number, 0] + ny * ways[number, 1] + nz * ways[number, 2])
        unsure[number] = along > OPPOSED * length
        if along > ASLANT * length:
            gaps[number] = 0.0


@_compiled
def search_nearest(x, lips, around, which, count, close, at, gaps):  # type: ignore[no-untyped-def]
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
