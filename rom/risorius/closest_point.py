"""Nearest point of a triangle (Ericson 2005, Real-Time Collision Detection, 5.1.5)."""

from __future__ import annotations

import numba


@numba.njit(cache=True, error_model="numpy")
def closest_point(px, py, pz, ax, ay, az, bx, by, bz, cx, cy, cz):  # type: ignore[no-untyped-def]
    """Square of the distance of p from the triangle a b c, and the three weights of its corners there.

    A corner that is off the feature that is nearest, an edge or a corner, has weight zero.
    """
    abx, aby, abz = bx - ax, by - ay, bz - az
    acx, acy, acz = cx - ax, cy - ay, cz - az
    apx, apy, apz = px - ax, py - ay, pz - az
    d1 = abx * apx + aby * apy + abz * apz
    d2 = acx * apx + acy * apy + acz * apz
    bb = abx * abx + aby * aby + abz * abz
    bc = abx * acx + aby * acy + abz * acz
    cc = acx * acx + acy * acy + acz * acz
    d3, d4, d5, d6 = d1 - bb, d2 - bc, d1 - bc, d2 - cc
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    u, v, s = 0.0, 0.0, 0.0
    if d1 <= 0.0 and d2 <= 0.0:
        u = 1.0
    elif d3 >= 0.0 and d4 <= d3:
        v = 1.0
    elif d6 >= 0.0 and d5 <= d6:
        s = 1.0
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        v = d1 / (d1 - d3)
        u = 1.0 - v
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        s = d2 / (d2 - d6)
        u = 1.0 - s
    elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        s = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        v = 1.0 - s
    else:
        total = va + vb + vc
        v, s = vb / total, vc / total
        u = 1.0 - v - s
    dx = apx - v * abx - s * acx
    dy = apy - v * aby - s * acy
    dz = apz - v * abz - s * acz
    return dx * dx + dy * dy + dz * dz, u, v, s
