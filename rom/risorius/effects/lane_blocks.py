"""Blocks of LANES triangles or vertices that are close to each other: which they are, and where."""

from __future__ import annotations

import math

import numba
import numpy as np
import numpy.typing as npt

from risorius.vector_lanes import LANES
from risorius.vector_sums import most_squared, sum_of_lanes

Numbers = npt.NDArray[np.int32]

NOWHERE = 1e3  # metres: the place of what there is not
ROUNDING = np.float32(1e-7)  # metres, of single precision
_A_CORNER, _A_LANE = np.float32(1 / (3 * LANES)), np.float32(1 / LANES)

_compiled = numba.njit(cache=True, error_model="numpy")


def blocks_of(places: npt.NDArray[np.floating], sides: npt.NDArray[np.integer]) -> tuple[Numbers, int]:
    """Numbers (b, LANES) of triangles at places (t, 3), on one of sides (t,), and where the blocks of side 1 begin.

    Those of side 0 come first. The last block of a side is filled up with a triangle that it has, and either side with
    rows of -1 up to whole LANES of blocks.
    """
    blocks = list[npt.NDArray[np.integer]]()
    split = 0
    for side in (0, 1):
        split = len(blocks)
        pending = [np.flatnonzero(sides == side)]
        while pending:
            block = pending.pop()
            if len(block) > LANES:
                along = places[block]
                block = block[np.argsort(along[:, np.ptp(along, axis=0).argmax()], kind="stable")]
                half = LANES * -(-len(block) // (2 * LANES))
                pending += [block[half:], block[:half]]
            elif len(block):
                blocks.append(np.append(block, np.full(LANES - len(block), block[-1])))
        blocks += [np.full(LANES, -1)] * (-len(blocks) % LANES)
    return np.array(blocks, np.int32).reshape(-1, LANES), split


@_compiled
def place_blocks(x, blocks, places, spheres):  # type: ignore[no-untyped-def]
    """Set places (3, b * LANES) of blocks (b, LANES) of vertices x (n, 3), and spheres (4, b) about what they have."""
    xs, ys, zs, radii = places[0], places[1], places[2], spheres[3]
    for block in range(len(blocks)):
        if blocks[block, 0] < 0:
            continue
        t = LANES * block
        for m in range(LANES):
            p = blocks[block, m]
            xs[t + m], ys[t + m], zs[t + m] = x[p, 0], x[p, 1], x[p, 2]
        u, v, w = sum_of_lanes(xs, t) * _A_LANE, sum_of_lanes(ys, t) * _A_LANE, sum_of_lanes(zs, t) * _A_LANE
        spheres[0, block], spheres[1, block], spheres[2, block] = u, v, w
        radii[block] = math.sqrt(most_squared(xs, ys, zs, t, u, v, w)) + ROUNDING


@_compiled
def enclose(corners, blocks, spheres):  # type: ignore[no-untyped-def]
    """Set spheres (4, b) about blocks (b, LANES) of triangles with corners (9, b * LANES)."""
    ax, ay, az, bx, by, bz, cx, cy, cz = (
        corners[0], corners[1], corners[2], corners[3], corners[4], corners[5], corners[6], corners[7], corners[8],
    )  # fmt: skip
    for block in range(len(blocks)):
        if blocks[block, 0] < 0:
            continue
        t = LANES * block
        u = (sum_of_lanes(ax, t) + sum_of_lanes(bx, t) + sum_of_lanes(cx, t)) * _A_CORNER
        v = (sum_of_lanes(ay, t) + sum_of_lanes(by, t) + sum_of_lanes(cy, t)) * _A_CORNER
        w = (sum_of_lanes(az, t) + sum_of_lanes(bz, t) + sum_of_lanes(cz, t)) * _A_CORNER
        most = max(most_squared(ax, ay, az, t, u, v, w), most_squared(bx, by, bz, t, u, v, w))
        most = max(most, most_squared(cx, cy, cz, t, u, v, w))
        spheres[0, block], spheres[1, block], spheres[2, block] = u, v, w
        spheres[3, block] = math.sqrt(most) + ROUNDING


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def turn_planes(corners, sign, sizes, planes):  # type: ignore[no-untyped-def]
    """Set planes (4, m) of triangles with corners (9, m): normals, of any length, outward with the sign, and offsets.

    sizes (m,): how far the other corners are from the first.
    """
    ax, ay, az, bx, by, bz, cx, cy, cz = (
        corners[0], corners[1], corners[2], corners[3], corners[4], corners[5], corners[6], corners[7], corners[8],
    )  # fmt: skip
    normals_x, normals_y, normals_z, offsets = planes[0], planes[1], planes[2], planes[3]
    outward = np.float32(sign)
    for t in range(len(sizes)):
        ux, uy, uz = bx[t] - ax[t], by[t] - ay[t], bz[t] - az[t]
        vx, vy, vz = cx[t] - ax[t], cy[t] - ay[t], cz[t] - az[t]
        nx, ny, nz = outward * (uy * vz - uz * vy), outward * (uz * vx - ux * vz), outward * (ux * vy - uy * vx)
        normals_x[t], normals_y[t], normals_z[t] = nx, ny, nz
        offsets[t] = nx * ax[t] + ny * ay[t] + nz * az[t]
        sizes[t] = math.sqrt(max(ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz)) + ROUNDING
