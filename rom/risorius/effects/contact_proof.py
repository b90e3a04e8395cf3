"""Looking at the lips as the measure of penetration does, where a quicker look may be wrong; nothing is allocated.

Every point is compared with all triangles of the other lip within DEEPEST. What is behind the nearest of them is in
tissue only if skin has closed around it since it was at rest, by its winding number (Jacobson et al. 2013).
"""

from __future__ import annotations

import math

import numba

from risorius.closest_point import closest_point
from risorius.effects.contact_kernels import DEEPEST, FAR, TOLERATED, smallest
from risorius.penetration import OUT_OF_ITSELF, WOUND
from risorius.winding_number import winding_number

_compiled = numba.njit(cache=True, error_model="numpy")

GROUP = 16  # triangles that are looked at together
ALIKE = 1e-3  # metres between points that are in tissue or out of it together


@_compiled
def _reach(x, vertices, order, starts, reaches):  # type: ignore[no-untyped-def]
    """Set how far, reaches (g,), points of patches are from their leaders."""
    for patch in range(len(reaches)):
        o, square = vertices[order[starts[patch]]], 0.0
        for e in range(starts[patch] + 1, starts[patch + 1]):
            p = vertices[order[e]]
            u, v, w = x[p, 0] - x[o, 0], x[p, 1] - x[o, 1], x[p, 2] - x[o, 2]
            square = max(square, u * u + v * v + w * w)
        reaches[patch] = math.sqrt(square)


@_compiled
def _enclose(x, triangles, members, centres, radii):  # type: ignore[no-untyped-def]
    """Set spheres, centres (g, 3) and radii (g,), about groups of triangles of vertices x (n, 3)."""
    for group in range(len(radii)):
        u, v, w, most = 0.0, 0.0, 0.0, 0.0
        for m in range(GROUP):
            for k in range(3):
                q = triangles[members[group, m], k]
                u, v, w = u + x[q, 0], v + x[q, 1], w + x[q, 2]
        u, v, w = u / (3 * GROUP), v / (3 * GROUP), w / (3 * GROUP)
        for m in range(GROUP):
            for k in range(3):
                q = triangles[members[group, m], k]
                a, b, c = x[q, 0] - u, x[q, 1] - v, x[q, 2] - w
                most = max(most, a * a + b * b + c * c)
        centres[group, 0], centres[group, 1], centres[group, 2], radii[group] = u, v, w, math.sqrt(most)


@_compiled
def turn_planes(x, triangles, members, sign, planes):  # type: ignore[no-untyped-def]
    """Set planes (4, g, GROUP) of members (g, GROUP): outward normals, and their offsets."""
    for group in range(len(members)):
        for m in range(GROUP):
            t = members[group, m]
            a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            ax, ay, az = x[a, 0], x[a, 1], x[a, 2]
            ux, uy, uz, vx, vy, vz = x[b, 0] - ax, x[b, 1] - ay, x[b, 2] - az, x[c, 0] - ax, x[c, 1] - ay, x[c, 2] - az
            nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
            scale = sign / max(math.sqrt(nx * nx + ny * ny + nz * nz), 1e-20)
            nx, ny, nz = scale * nx, scale * ny, scale * nz
            planes[0, group, m], planes[1, group, m], planes[2, group, m] = nx, ny, nz
            planes[3, group, m] = nx * ax + ny * ay + nz * az


@_compiled
def _near_groups(px, py, pz, side, reach, group_sides, centres, radii, near):  # type: ignore[no-untyped-def]
    """Write the numbers of groups of the other side within reach of a point; return how many."""
    found = 0
    for group in range(len(radii)):
        a, b, c = centres[group, 0] - px, centres[group, 1] - py, centres[group, 2] - pz
        most = radii[group] + reach
        near[found] = group
        found += (group_sides[group] != side) & (a * a + b * b + c * c < most * most)
    return found


@_compiled
def _candidates(  # type: ignore[no-untyped-def]
    x, rest, vertices, triangles, turned, faced, at, members, order, begin, end, centres, radii, near, found, gaps,
    which, count,
):  # fmt: skip
    """Write the numbers of points of a patch, order[begin:end], that may be in the other lip; return how many now.

    These are behind a triangle, before which they are at rest, no farther from it than from the one that they are `at`.
    """
    for e in range(begin, end):
        number = order[e]
        gaps[number] = FAR
        if found == 0:
            continue
        p, t = vertices[number], at[number]
        px, py, pz = x[p, 0], x[p, 1], x[p, 2]
        ox, oy, oz = rest[p, 0], rest[p, 1], rest[p, 2]
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        square = closest_point(
            px, py, pz, x[a, 0], x[a, 1], x[a, 2], x[b, 0], x[b, 1], x[b, 2], x[c, 0], x[c, 1], x[c, 2]
        )[0]
        reach = min(math.sqrt(square) * (1.0 + 1e-4) + 1e-7, DEEPEST)
        gaps[number] = reach
        deep = False
        for k in range(found):
            group = near[k]
            a, b, c = centres[group, 0] - px, centres[group, 1] - py, centres[group, 2] - pz
            most = radii[group] + reach
            if a * a + b * b + c * c > most * most:
                continue
            behind = 0
            for m in range(GROUP):
                now = turned[0, group, m] * px + turned[1, group, m] * py + turned[2, group, m] * pz
                then = faced[0, group, m] * ox + faced[1, group, m] * oy + faced[2, group, m] * oz
                behind += (now < turned[3, group, m]) & (then >= faced[3, group, m])
            if behind == 0:
                continue
            for m in range(GROUP):
                now = turned[0, group, m] * px + turned[1, group, m] * py + turned[2, group, m] * pz
                then = faced[0, group, m] * ox + faced[1, group, m] * oy + faced[2, group, m] * oz
                if now >= turned[3, group, m] or then < faced[3, group, m]:
                    continue
                t = members[group, m]
                a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
                square = closest_point(
                    px, py, pz, x[a, 0], x[a, 1], x[a, 2], x[b, 0], x[b, 1], x[b, 2], x[c, 0], x[c, 1], x[c, 2]
                )[0]
                deep = deep or square <= reach * reach
            if deep:
                break
        if deep:
            which[count] = number
            count += 1
    return count


@_compiled
def _nearest(  # type: ignore[no-untyped-def]
    px, py, pz, ox, oy, oz, x, triangles, across, planes, sign, border, members, centres, radii, near, found, way
):
    """Gap to the nearest triangle of the groups near a point, at (ox, oy, oz) at rest, and which; sets the way out."""
    least, cosine, best, w0, w1, w2 = DEEPEST * DEEPEST, 0.0, -1, 0.0, 0.0, 0.0
    for k in range(found):
        group = near[k]
        a, b, c = centres[group, 0] - px, centres[group, 1] - py, centres[group, 2] - pz
        most = radii[group] + math.sqrt(least) * (1.0 + 1e-6)
        if a * a + b * b + c * c > most * most:
            continue
        for m in range(GROUP):
            t = members[group, m]
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
    nx, ny, nz = 0.0, 0.0, 0.0
    for m in range(fan_starts[vertex], fan_starts[vertex + 1]):
        t = fans[m]
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
        vx, vy, vz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
        nx, ny, nz = nx + uy * vz - uz * vy, ny + uz * vx - ux * vz, nz + ux * vy - uy * vx
    scale = sign * OUT_OF_ITSELF / max(math.sqrt(nx * nx + ny * ny + nz * nz), 1e-20)
    place[0], place[1], place[2] = x[vertex, 0] + scale * nx, x[vertex, 1] + scale * ny, x[vertex, 2] + scale * nz


@_compiled
def _deepest_of(patch, order, starts, gaps):  # type: ignore[no-untyped-def]
    """Number of the deepest point of a patch, -1 where none is deeper than TOLERATED."""
    deepest, gap = -1, -TOLERATED
    for e in range(starts[patch], starts[patch + 1]):
        if gaps[order[e]] < gap:
            deepest, gap = order[e], gaps[order[e]]
    return deepest


@_compiled
def _believe(x, rest, points, triangles, sign, skin, place, gaps):  # type: ignore[no-untyped-def]
    """Turn gaps (l,) of what is deeper than TOLERATED, but around which no skin has closed, into positive ones.

    That is asked of the deepest point of a patch, for all that lies within ALIKE of it, and of what is deepest then.
    """
    vertices, _sides, order, starts, fan_starts, fans, at_rest = points
    for patch in range(len(starts) - 1):
        deepest = _deepest_of(patch, order, starts, gaps)
        while deepest >= 0:
            o = vertices[deepest]
            if math.isnan(at_rest[deepest]):
                _beside(rest, o, fan_starts, fans, triangles, sign, place)
                at_rest[deepest] = sign * winding_number(place, rest, skin)
            _beside(x, o, fan_starts, fans, triangles, sign, place)
            if sign * winding_number(place, x, skin) - at_rest[deepest] > WOUND:
                break
            for e in range(starts[patch], starts[patch + 1]):
                p = vertices[order[e]]
                u, v, w = x[p, 0] - x[o, 0], x[p, 1] - x[o, 1], x[p, 2] - x[o, 2]
                if u * u + v * v + w * w <= ALIKE * ALIKE:
                    gaps[order[e]] = abs(gaps[order[e]])
            deepest = _deepest_of(patch, order, starts, gaps)


@_compiled
def prove(x, rest, points, surface, groups, work, state):  # type: ignore[no-untyped-def]
    """Set gaps (l,) of all points of the lips, negative in the other lip, and ways out of it; return the smallest.

    points: vertices (l,), their sides, patches of them, triangles around each of all vertices, and winding numbers at
    rest, NaN where not known yet. surface: triangles of the lips as in `ContactTables`, flags of their borders, and
    triangles of all skin around. groups: numbers of triangles, their planes at rest, the sides that these are on.
    """
    vertices, sides, order, order_starts = points[:4]
    triangles, across, planes, sign, border, skin = surface
    members, faced, group_sides = groups
    centres, radii, reaches, turned, near, place = work
    at, which, gaps, ways = state
    _reach(x, vertices, order, order_starts, reaches)
    _enclose(x, triangles, members, centres, radii)
    turn_planes(x, triangles, members, sign, turned)
    count = 0
    for patch in range(len(order_starts) - 1):
        begin, end = order_starts[patch], order_starts[patch + 1]
        leader = order[begin]
        p, reach = vertices[leader], DEEPEST + reaches[patch]
        found = _near_groups(x[p, 0], x[p, 1], x[p, 2], sides[leader], reach, group_sides, centres, radii, near)
        count = _candidates(
            x, rest, vertices, triangles, turned, faced, at, members, order, begin, end, centres, radii, near, found,
            gaps, which, count,
        )  # fmt: skip
    for e in range(count):
        number = which[e]
        p = vertices[number]
        px, py, pz = float(x[p, 0]), float(x[p, 1]), float(x[p, 2])
        found = _near_groups(px, py, pz, sides[number], DEEPEST, group_sides, centres, radii, near)
        gaps[number], best = _nearest(
            px, py, pz, float(rest[p, 0]), float(rest[p, 1]), float(rest[p, 2]), x, triangles, across, planes, sign,
            border, members, centres, radii, near, found, place,
        )  # fmt: skip
        at[number] = at[number] if best < 0 else best
        ways[number, 0], ways[number, 1], ways[number, 2] = place[0], place[1], place[2]
    _believe(x, rest, points, triangles, sign, skin, place, gaps)
    return smallest(gaps)
