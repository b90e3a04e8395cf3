"""Looking at the lips as the measure of penetration does, where a quicker look may be wrong; nothing is allocated.

Every point that is not known to be clear is compared with all triangles of the other lip within DEEPEST, LANES of them
at a time. What is behind the nearest of them is in tissue only if skin has closed around it since it was at rest, by
its winding number (Jacobson et al. 2013).
"""

from __future__ import annotations

import math

import numba
import numpy as np

from risorius.closest_point import closest_point
from risorius.effects.contact_gaps import smallest
from risorius.effects.lane_blocks import NOWHERE, ROUNDING, enclose, turn_planes
from risorius.effects.lip_gaps import DEEPEST, FAR, TOLERATED
from risorius.effects.skin_around import place_skin
from risorius.normals import fan_normal
from risorius.penetration import OUT_OF_ITSELF, WOUND
from risorius.vector_lanes import LANES
from risorius.vector_masks import first_lane, lanes_behind, lanes_within
from risorius.vector_sums import least_squared
from risorius.winding_number import place_corners, winding_number_of

_compiled = numba.njit(cache=True, error_model="numpy")

ALIKE = 1e-3  # metres between points of a lip that are in tissue or out of it together


@_compiled
def _near_blocks(px, py, pz, reach, first, last, spheres, near, near_spheres):  # type: ignore[no-untyped-def]
    """Write the blocks of first:last within reach of a point, numbers and spheres, up to whole LANES; return how many.

    What fills up the LANES is near nothing.
    """
    xs, ys, zs, radii = spheres[0], spheres[1], spheres[2], spheres[3]
    found = 0
    for start in range(first, last, LANES):
        within = lanes_within(xs, ys, zs, radii, start, px, py, pz, reach)
        while within != 0:
            block = start + first_lane(within)
            within &= within - 1
            near[found] = block
            for i in range(4):
                near_spheres[i, found] = spheres[i, block]
            found += 1
    for k in range(found, found + LANES):
        near_spheres[0, k] = NOWHERE
    return found


@_compiled
def _candidates(  # type: ignore[no-untyped-def]
    x, rest, vertices, triangles, turned, faced, corners, sizes, at, members, order, begin, end, near, near_spheres,
    found, gaps, which, count,
):  # fmt: skip
    """Write the numbers of points of a patch, order[begin:end], that may be in the other lip; return how many now.

    These are behind a triangle, before which they are at rest, no farther from it than from the one that they are `at`,
    and than from a corner of each that is near. Gaps (l,) of more than 0 are of points that are clear, and become at
    least as large as the distance of others.
    """
    xs, ys, zs, radii = near_spheres[0], near_spheres[1], near_spheres[2], near_spheres[3]
    cx, cy, cz = corners[0], corners[1], corners[2]
    tx, ty, tz, offsets = turned[0], turned[1], turned[2], turned[3]
    fx, fy, fz, offsets_rest = faced[0], faced[1], faced[2], faced[3]
    for e in range(begin, end):
        number = order[e]
        if gaps[number] > 0.0:
            continue
        p, t = vertices[number], at[number]
        px, py, pz = x[p, 0], x[p, 1], x[p, 2]
        ox, oy, oz = rest[p, 0], rest[p, 1], rest[p, 2]
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        square = closest_point(
            px, py, pz, x[a, 0], x[a, 1], x[a, 2], x[b, 0], x[b, 1], x[b, 2], x[c, 0], x[c, 1], x[c, 2]
        )[0]
        reach = np.float32(min(math.sqrt(square) * (1.0 + 1e-4) + ROUNDING, DEEPEST))
        least = reach * reach
        for start in range(0, found, LANES):
            within = lanes_within(xs, ys, zs, radii, start, px, py, pz, reach)
            while within != 0:
                block = near[start + first_lane(within)]
                within &= within - 1
                least = min(least, least_squared(cx, cy, cz, LANES * block, px, py, pz))
        reach = min(reach, np.float32(math.sqrt(least) * np.float32(1.0 + 1e-4) + ROUNDING))
        gaps[number] = reach
        deep = False
        for start in range(0, found, LANES):
            within = lanes_within(xs, ys, zs, radii, start, px, py, pz, reach)
            while within != 0 and not deep:
                block = near[start + first_lane(within)]
                within &= within - 1
                behind = lanes_behind(tx, ty, tz, offsets, LANES * block, px, py, pz)
                behind &= ~lanes_behind(fx, fy, fz, offsets_rest, LANES * block, ox, oy, oz)
                behind &= lanes_within(cx, cy, cz, sizes, LANES * block, px, py, pz, reach)
                while behind != 0 and not deep:
                    t = members[block, first_lane(behind)]
                    behind &= behind - 1
                    a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
                    square = closest_point(
                        px, py, pz, x[a, 0], x[a, 1], x[a, 2], x[b, 0], x[b, 1], x[b, 2], x[c, 0], x[c, 1], x[c, 2]
                    )[0]
                    deep = square <= reach * reach
        if deep:
            which[count] = number
            count += 1
    return count


@_compiled
def _nearest(  # type: ignore[no-untyped-def]
    px,
    py,
    pz,
    ox,
    oy,
    oz,
    most,
    x,
    triangles,
    across,
    planes,
    sign,
    border,
    members,
    corners,
    sizes,
    near,
    near_spheres,
    found,
    way,
):
    """Gap to the nearest triangle of the blocks near a point, at (ox, oy, oz) at rest, and which; sets the way out.

    most: metres that it is not farther than.
    """
    xs, ys, zs = corners[0], corners[1], corners[2]
    fx, fy, fz = np.float32(px), np.float32(py), np.float32(pz)
    least, cosine, best, w0, w1, w2 = most * most, 0.0, -1, 0.0, 0.0, 0.0
    for k in range(found):
        block = near[k]
        a, b, c = near_spheres[0, k] - px, near_spheres[1, k] - py, near_spheres[2, k] - pz
        reach = math.sqrt(least) * (1.0 + 1e-6)
        if a * a + b * b + c * c > (near_spheres[3, k] + reach) ** 2:
            continue
        within = lanes_within(xs, ys, zs, sizes, LANES * block, fx, fy, fz, np.float32(reach + ROUNDING))
        while within != 0:
            t = members[block, first_lane(within)]
            within &= within - 1
            a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            ax, ay, az = float(x[a, 0]), float(x[a, 1]), float(x[a, 2])
            bx, by, bz = float(x[b, 0]), float(x[b, 1]), float(x[b, 2])
            cx, cy, cz = float(x[c, 0]), float(x[c, 1]), float(x[c, 2])
            square, v0, v1, v2 = closest_point(px, py, pz, ax, ay, az, bx, by, bz, cx, cy, cz)
            if square > least * (1.0 + 1e-9):
                continue
            ux, uy, uz, vx, vy, vz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
            nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
            rx = px - v0 * ax - v1 * bx - v2 * cx
            ry = py - v0 * ay - v1 * by - v2 * cy
            rz = pz - v0 * az - v1 * bz - v2 * cz
            size = math.sqrt((nx * nx + ny * ny + nz * nz) * square)
            turned = sign * (nx * rx + ny * ry + nz * rz) / max(size, 1e-30)
            if square < least * (1.0 - 1e-9) or abs(turned) > abs(cosine):
                least, cosine, best, w0, w1, w2 = min(square, least), turned, t, v0, v1, v2
                way[0], way[1], way[2] = -rx, -ry, -rz
    if best < 0:
        return FAR, best
    gap = math.sqrt(least)
    for k in range(3):
        way[k] /= max(gap, 1e-12)
    behind = planes[best, 0] * ox + planes[best, 1] * oy + planes[best, 2] * oz < planes[best, 3]
    ends = (w0 == 0.0 and across[best, 1] < 0) or (w1 == 0.0 and across[best, 2] < 0)
    ends = ends or (w2 == 0.0 and across[best, 0] < 0)
    ends = ends or (w0 == 1.0 and border[triangles[best, 0]]) or (w1 == 1.0 and border[triangles[best, 1]])
    ends = ends or (w2 == 1.0 and border[triangles[best, 2]])
    return gap if cosine >= 0.0 or behind or ends else -gap, best


@_compiled
def _beside(x, vertex, fan_starts, fans, triangles, sign, place):  # type: ignore[no-untyped-def]
    """Set a place just outside of a vertex, off the triangles around it."""
    nx, ny, nz = fan_normal(x, vertex, fan_starts, fans, triangles)
    scale = sign * OUT_OF_ITSELF / max(math.sqrt(nx * nx + ny * ny + nz * nz), 1e-20)
    place[0], place[1], place[2] = x[vertex, 0] + scale * nx, x[vertex, 1] + scale * ny, x[vertex, 2] + scale * nz


@_compiled
def _deepest_of(which, count, told, gaps):  # type: ignore[no-untyped-def]
    """Number of the deepest of candidates that nothing is told of yet, -1 where none is deeper than TOLERATED."""
    deepest, gap = -1, -TOLERATED
    for e in range(count):
        if told[e] == 0 and gaps[which[e]] < gap:
            deepest, gap = which[e], gaps[which[e]]
    return deepest


@_compiled
def _keep_around(x, vertices, sides, o, which, count, told, gaps):  # type: ignore[no-untyped-def]
    """Tell candidates that they are inside: those on the lip of point o, which is, and within reach of it."""
    side, q, reach = sides[o], vertices[o], max(ALIKE, -gaps[o])
    for e in range(count):
        p = vertices[which[e]]
        u, v, w = x[p, 0] - x[q, 0], x[p, 1] - x[q, 1], x[p, 2] - x[q, 2]
        if sides[which[e]] == side and u * u + v * v + w * w <= reach * reach:
            told[e] = 1


@_compiled
def _believe(x, rest, points, sign, skin, place, which, count, gaps):  # type: ignore[no-untyped-def]
    """Turn gaps of candidates that are deeper than TOLERATED, but around which no skin has closed, into positive ones.

    That is asked of the deepest, then of what is deepest of the others. What is nearer to one that is inside than that
    is to the other lip is inside, too, since no surface is in between. Outside, winding numbers are too close to WOUND
    around a rim for one to tell of others.
    """
    vertices, sides, _order, _starts, triangles, fan_starts, fans, at_rest = points
    of_rest, corners, told, around, edges, apex = skin
    told[:count] = 0
    deepest, placed = _deepest_of(which, count, told, gaps), False
    while deepest >= 0:
        if not placed:
            place_skin(x, around, edges, apex, corners)
            placed = True
        if math.isnan(at_rest[deepest]):
            _beside(rest, vertices[deepest], fan_starts, fans, triangles, sign, place)
            at_rest[deepest] = sign * winding_number_of(place[0], place[1], place[2], of_rest)
        _beside(x, vertices[deepest], fan_starts, fans, triangles, sign, place)
        if sign * winding_number_of(place[0], place[1], place[2], corners) - at_rest[deepest] > WOUND:
            _keep_around(x, vertices, sides, deepest, which, count, told, gaps)
        else:
            gaps[deepest] = -gaps[deepest]
        deepest = _deepest_of(which, count, told, gaps)


@_compiled
def prove(x, rest, points, surface, blocks, work, state):  # type: ignore[no-untyped-def]
    """Set gaps (l,) of the points of the lips, negative in the other lip, and ways out of it; return the smallest.

    Gaps that are more than 0 before are of points that are known to be clear. points: vertices (l,), their sides,
    patches of them, triangles of all skin, those around each vertex, and winding numbers at rest, NaN where not known.
    surface: triangles of the lips as in `ContactTables`, flags of their borders, and of skin around: corners at rest,
    working space for these now and for what has been told, and what `place_skin` takes. blocks: numbers of triangles,
    those of side 0 first, rows of -1 up to whole LANES, the triangles, their planes at rest, and where those of side 1
    begin.
    """
    vertices, sides, order, order_starts = points[:4]
    triangles, across, planes, sign, border, skin = surface
    members, grouped, faced, split = blocks
    reaches, spheres, corners, sizes, turned, near, near_spheres, way, place = work
    at, which, gaps, ways = state
    place_corners(x, grouped, corners)
    enclose(corners, members, spheres)
    turn_planes(corners, sign, sizes, turned)
    count = 0
    for patch in range(len(order_starts) - 1):
        begin, end = order_starts[patch], order_starts[patch + 1]
        if _least(order, begin, end, gaps) > 0.0:
            continue
        leader = order[begin]
        first, last = (split, len(members)) if sides[leader] == 0 else (0, split)
        p, reach = vertices[leader], np.float32(DEEPEST + reaches[patch])
        found = _near_blocks(x[p, 0], x[p, 1], x[p, 2], reach, first, last, spheres, near, near_spheres)
        count = _candidates(
            x, rest, vertices, triangles, turned, faced, corners, sizes, at, members, order, begin, end, near,
            near_spheres, found, gaps, which, count,
        )  # fmt: skip
    for e in range(count):
        number = which[e]
        p = vertices[number]
        first, last = (split, len(members)) if sides[number] == 0 else (0, split)
        reach = np.float32(gaps[number])
        found = _near_blocks(x[p, 0], x[p, 1], x[p, 2], reach, first, last, spheres, near, near_spheres)
        gaps[number], best = _nearest(
            float(x[p, 0]), float(x[p, 1]), float(x[p, 2]), float(rest[p, 0]), float(rest[p, 1]), float(rest[p, 2]),
            gaps[number], x, triangles, across, planes, sign, border, members, corners, sizes, near, near_spheres,
            found, way,
        )  # fmt: skip
        at[number] = at[number] if best < 0 else best
        ways[number, 0], ways[number, 1], ways[number, 2] = way[0], way[1], way[2]
    _believe(x, rest, points, sign, skin, place, which, count, gaps)
    return smallest(gaps)


@_compiled
def _least(order, begin, end, gaps):  # type: ignore[no-untyped-def]
    """Smallest gap that is known of any point of a patch."""
    least = FAR
    for e in range(begin, end):
        least = min(least, gaps[order[e]])
    return least
