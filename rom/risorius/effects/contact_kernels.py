"""Finding skin that is in teeth or in the other lip, and moving it out; nothing is allocated, nothing is random."""

from __future__ import annotations

import math

import numba

from risorius.closest_point import closest_point

_compiled = numba.njit(cache=True, error_model="numpy")
_inlined = numba.njit(cache=True, error_model="numpy", inline="always")

SWEEPS = 6  # at most, of a frame
NEAR = 0.7e-3  # metres: a point with a wider gap is not looked at again in the same frame
ENOUGH = 0.05e-3  # metres: no sweep for less
GAIN = 1.25  # of a sweep, which moves by weighted means and so falls short of the deepest
HALF = 0.6  # of a depth in the other lip, which gives way, too
ASIDE = 0.3  # cosine between the nearest way out of a tooth and that at rest, below which the latter is taken
LONGEST_WAY = 8  # steps along it
SHORTEST_STEP = 0.1e-3  # metres
FAR = 8e-3  # metres between lips that cannot touch
LONGEST_WALK = 16  # triangles
DEEPEST = 4e-3  # metres; what is farther behind a lip is not in it


@_inlined
def _seen(p, turn, origin, y):  # type: ignore[no-untyped-def]
    """Write where p is as seen from a body that has gone to turn x + origin."""
    a, b, c = p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]
    for i in range(3):
        y[i] = turn[0, i] * a + turn[1, i] * b + turn[2, i] * c


@_compiled
def distance(grid, start, shape, low, spacing, y, slope):  # type: ignore[no-untyped-def]
    """Distance at y between the points of a grid, and its derivative; 1 m beyond the grid."""
    u, v, w = (y[0] - low[0]) / spacing, (y[1] - low[1]) / spacing, (y[2] - low[2]) / spacing
    if not (0.0 <= u < shape[0] - 1 and 0.0 <= v < shape[1] - 1 and 0.0 <= w < shape[2] - 1):
        return 1.0
    i, j, k = int(u), int(v), int(w)
    u, v, w = u - i, v - j, w - k
    step_j, step_i = shape[2], shape[1] * shape[2]
    n = start + i * step_i + j * step_j + k
    c000, c001, c010, c011 = grid[n], grid[n + 1], grid[n + step_j], grid[n + step_j + 1]
    n += step_i
    c100, c101, c110, c111 = grid[n], grid[n + 1], grid[n + step_j], grid[n + step_j + 1]
    c00, c01, c10, c11 = (c000 + w * (c001 - c000), c010 + w * (c011 - c010),
                          c100 + w * (c101 - c100), c110 + w * (c111 - c110))  # fmt: skip
    c0, c1 = c00 + v * (c01 - c00), c10 + v * (c11 - c10)
    slope[0] = (c1 - c0) / spacing
    slope[1] = ((1.0 - u) * (c01 - c00) + u * (c11 - c10)) / spacing
    slope[2] = ((1.0 - u) * ((1.0 - v) * (c001 - c000) + v * (c011 - c010))
                + u * ((1.0 - v) * (c101 - c100) + v * (c111 - c110))) / spacing  # fmt: skip
    return c0 + u * (c1 - c0)


@_compiled
def _way_out(grid, start, shape, low, spacing, onset, y, out, slope):  # type: ignore[no-untyped-def]
    """How far y is from being out of an obstacle along a unit vector; moves y there."""
    way = 0.0
    for _ in range(LONGEST_WAY):
        depth = onset - distance(grid, start, shape, low, spacing, y, slope)
        if depth <= 0.0:
            break
        step = max(depth, SHORTEST_STEP)
        way += step
        for i in range(3):
            y[i] += step * out[i]
    return way


@_compiled
def gap_to_teeth(x, number, points, onset, away, teeth, body, y, slope, n):  # type: ignore[no-untyped-def]
    """Smallest gap of a point; its way out, in the frame of the head, in n."""
    grid, starts, shapes, lows, spacings, moves = teeth
    turn, origin = body
    smallest = 1.0
    p = x[points[number]]
    for o in range(len(starts)):
        if not onset[number, o] > -1.0:
            continue
        if moves[o]:
            _seen(p, turn, origin, y)
        else:
            y[0], y[1], y[2] = p[0], p[1], p[2]
        gap = distance(grid, starts[o], shapes[o], lows[o], spacings[o], y, slope) - onset[number, o]
        if gap >= smallest:
            continue
        out = away[number, o]
        length = max(math.sqrt(slope[0] ** 2 + slope[1] ** 2 + slope[2] ** 2), 1e-12)
        for i in range(3):
            slope[i] /= length
        if gap < 0.0 and slope[0] * out[0] + slope[1] * out[1] + slope[2] * out[2] < ASIDE:
            gap = -_way_out(grid, starts[o], shapes[o], lows[o], spacings[o], onset[number, o], y, out, slope)
            slope[0], slope[1], slope[2] = out[0], out[1], out[2]
        smallest = gap
        for i in range(3):
            if moves[o]:
                n[i] = turn[i, 0] * slope[0] + turn[i, 1] * slope[1] + turn[i, 2] * slope[2]
            else:
                n[i] = slope[i]
    return smallest


@_compiled
def _add_normal(x, corners, sign, n):  # type: ignore[no-untyped-def]
    a, b, c = x[corners[0]], x[corners[1]], x[corners[2]]
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    scale = sign / max(math.sqrt(nx * nx + ny * ny + nz * nz), 1e-20)
    n[0] += nx * scale
    n[1] += ny * scale
    n[2] += nz * scale


@_compiled
def gap_to_lip(x, p, t, triangles, across, sign, w, trial, n):  # type: ignore[no-untyped-def]
    """Gap of vertex p to the nearest triangle from t on, and that triangle; the way out in n. 1 m where there is none.

    Downhill from triangle to triangle across the edges that the nearest point lies on.
    """
    square = closest_point(x[p], x[triangles[t, 0]], x[triangles[t, 1]], x[triangles[t, 2]], w)
    for _ in range(LONGEST_WALK):
        following = -1
        for k in range(3):
            other = across[t, k]
            if w[(k + 2) % 3] != 0.0 or other < 0:
                continue
            s = closest_point(x[p], x[triangles[other, 0]], x[triangles[other, 1]], x[triangles[other, 2]], trial)
            if s < square * (1.0 - 1e-6):
                square, following = s, other
        if following < 0:
            break
        t = following
        square = closest_point(x[p], x[triangles[t, 0]], x[triangles[t, 1]], x[triangles[t, 2]], w)
    n[0], n[1], n[2] = 0.0, 0.0, 0.0
    _add_normal(x, triangles[t], sign, n)
    for k in range(3):
        if w[(k + 2) % 3] == 0.0:
            if across[t, k] < 0:
                return 1.0, t
            _add_normal(x, triangles[across[t, k]], sign, n)
    side = 0.0
    for i in range(3):
        foot = w[0] * x[triangles[t, 0], i] + w[1] * x[triangles[t, 1], i] + w[2] * x[triangles[t, 2], i]
        side += n[i] * (x[p, i] - foot)
    length = max(math.sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2), 1e-12)
    for i in range(3):
        n[i] /= length
    return (math.sqrt(square) if side >= 0.0 else -math.sqrt(square)), t


@_compiled
def _in_front_at_rest(place, plane):  # type: ignore[no-untyped-def]
    return plane[0] * place[0] + plane[1] * place[1] + plane[2] * place[2] >= plane[3]


@_compiled
def find(x, teeth_points, teeth, body, lips, near, near_lips, at, scratch):  # type: ignore[no-untyped-def]
    """Write the points with a gap below NEAR; return how many of teeth and of lips, and the smallest gap."""
    points, onset, away = teeth_points
    vertices, facing, places, triangles, across, planes, sign = lips
    y, slope, n, w, trial = scratch
    smallest, count, count_lips = 1.0, 0, 0
    for number in range(len(points)):
        gap = gap_to_teeth(x, number, points, onset, away, teeth, body, y, slope, n)
        if gap < NEAR:
            near[count] = number
            count += 1
            smallest = min(smallest, gap)
    for number in range(len(vertices)):
        p, t = x[vertices[number]], facing[number]
        a = x[triangles[t, 0]]
        if (p[0] - a[0]) ** 2 + (p[1] - a[1]) ** 2 + (p[2] - a[2]) ** 2 > FAR * FAR:
            continue
        gap, t = gap_to_lip(x, vertices[number], t, triangles, across, sign, w, trial, n)
        if -DEEPEST < gap < NEAR and _in_front_at_rest(places[number], planes[t]):
            near_lips[count_lips], at[number] = number, t
            count_lips += 1
            smallest = min(smallest, gap)
    return count, count_lips, smallest


@_compiled
def _push(vertex, depth, n, starts, controls, shares, wanted, total):  # type: ignore[no-untyped-def]
    for e in range(starts[vertex], starts[vertex + 1]):
        share, c = shares[e] * depth, controls[e]
        total[c] += share
        for i in range(3):
            wanted[c, i] += share * depth * n[i]


@_compiled
def _move(x, wanted, total, starts, vertices, shares):  # type: ignore[no-untyped-def]
    """Move the vertices by what the controls want in the mean, weighted by depth."""
    for c in range(len(total)):
        if total[c] <= 0.0:
            continue
        scale = GAIN / total[c]
        dx, dy, dz = wanted[c, 0] * scale, wanted[c, 1] * scale, wanted[c, 2] * scale
        for e in range(starts[c], starts[c + 1]):
            v, share = vertices[e], shares[e]
            x[v, 0] += share * dx
            x[v, 1] += share * dy
            x[v, 2] += share * dz


@_compiled
def resolve(x, teeth_points, teeth, body, lips, rows, columns, state):  # type: ignore[no-untyped-def]
    """Move vertices x (n, 3) out of teeth and lips; return the number of sweeps."""
    points, onset, away = teeth_points
    vertices, facing, places, triangles, across, planes, sign = lips
    near, near_lips, at, wanted, total, scratch = state
    y, slope, n, w, trial = scratch
    count, count_lips, smallest = find(x, teeth_points, teeth, body, lips, near, near_lips, at, scratch)
    if smallest > -ENOUGH:
        return 0
    for sweep in range(SWEEPS):
        deepest = 0.0
        wanted[:] = 0.0
        total[:] = 0.0
        for e in range(count):
            number = near[e]
            gap = gap_to_teeth(x, number, points, onset, away, teeth, body, y, slope, n)
            if gap < 0.0:
                deepest = max(deepest, -gap)
                _push(points[number], -gap, n, rows[0], rows[1], rows[2], wanted, total)
        for e in range(count_lips):
            number = near_lips[e]
            gap, at[number] = gap_to_lip(x, vertices[number], at[number], triangles, across, sign, w, trial, n)
            if -DEEPEST < gap < 0.0 and _in_front_at_rest(places[number], planes[at[number]]):
                deepest = max(deepest, -gap)
                _push(vertices[number], -HALF * gap, n, rows[0], rows[1], rows[2], wanted, total)
        if deepest < ENOUGH:
            return sweep
        _move(x, wanted, total, columns[0], columns[1], columns[2])
    return SWEEPS
