"""How far points are from teeth, and which way out of them; nothing is allocated."""

from __future__ import annotations

import math

import numba

from risorius.effects.teeth_blocks import BLOCK, blocks

_compiled = numba.njit(cache=True, error_model="numpy")

APART = 1.0  # metres: a gap where there is nothing to touch
CLEAR = 1e-3  # metres
ASIDE = 0.0  # cosine between the nearest way out of a tooth and that at rest, below which the latter is taken
LONGEST_WAY = 8  # steps along it
SHORTEST_STEP = 0.1e-3  # metres


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
