"""Which points are known to be clear of teeth by the block of a grid of distances that they are in; it only bounds.

Without branches, so that the compiler has many points at a time.
"""

from __future__ import annotations

import numba
import numpy as np

_compiled = numba.njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc"})

BLOCK = 4  # steps of a grid, along each axis, of which the least distance is kept


@numba.njit(cache=True, error_model="numpy")
def blocks(size):  # type: ignore[no-untyped-def]
    """Number of blocks along an axis of a grid."""
    return (size - 2) // BLOCK + 1


@_compiled
def beyond_blocks(  # type: ignore[no-untyped-def]
    places, onsets, shapes, lows, spacings, moves, least, least_starts, turn, origin, turned, cells, gaps
):
    """Lower gaps (k,) of points at places (3, k) to the least that any obstacle leaves them in their block.

    onsets (o, k): gaps at which contact with obstacles begins, less than -1 where there is none. least: distances of
    the blocks of all grids, which start at least_starts (o,), then one beyond each grid. Obstacles that move are at
    turn (3, 3) @ place + origin (3,). turned (3, 4), cells (k,): working space.
    """
    px, py, pz = places[0], places[1], places[2]
    for o in range(len(onsets)):
        per_metre = 1.0 / (BLOCK * spacings[o])
        for i in range(3):
            low = lows[o, i]
            for j in range(3):
                turned[i, j] = per_metre * (turn[j, i] if moves[o] else (1.0 if i == j else 0.0))
                low += turn[j, i] * origin[j] if moves[o] else 0.0
            turned[i, 3] = -per_metre * low
        a0, a1, a2, a3 = turned[0, 0], turned[0, 1], turned[0, 2], turned[0, 3]
        b0, b1, b2, b3 = turned[1, 0], turned[1, 1], turned[1, 2], turned[1, 3]
        c0, c1, c2, c3 = turned[2, 0], turned[2, 1], turned[2, 2], turned[2, 3]
        most_a = np.float32((shapes[o, 0] - 1) / BLOCK)
        most_b = np.float32((shapes[o, 1] - 1) / BLOCK)
        most_c = np.float32((shapes[o, 2] - 1) / BLOCK)
        across, along = np.int32(blocks(shapes[o, 1])), np.int32(blocks(shapes[o, 2]))
        first, outside, nothing = np.int32(least_starts[o]), np.int32(len(least) - len(onsets) + o), np.float32(0.0)
        for k in range(len(cells)):
            a = a0 * px[k] + a1 * py[k] + a2 * pz[k] + a3
            b = b0 * px[k] + b1 * py[k] + b2 * pz[k] + b3
            c = c0 * px[k] + c1 * py[k] + c2 * pz[k] + c3
            inside = (a >= nothing) & (a < most_a) & (b >= nothing) & (b < most_b) & (c >= nothing) & (c < most_c)
            block = (np.int32(a if inside else nothing) * across + np.int32(b if inside else nothing)) * along
            block += first + np.int32(c if inside else nothing)
            cells[k] = block if inside else outside
        onset = onsets[o]
        for k in range(len(cells)):
            gaps[k] = min(gaps[k], least[np.uint32(cells[k])] - onset[k])
