"""Generalised winding number of triangles around a point (Jacobson et al. 2013): one inside, zero outside.

Where the surface is open it is what the triangles cover of the whole sphere of directions, between the two.
"""

from __future__ import annotations

import math

import numba


@numba.njit(cache=True, error_model="numpy")
def winding_number(point, x, triangles):  # type: ignore[no-untyped-def]
    """Winding number at a point (3,) of triangles (m, 3) of vertices x (n, 3), by solid angles (Van Oosterom 1983)."""
    total = 0.0
    for t in range(len(triangles)):
        i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        ax, ay, az = x[i, 0] - point[0], x[i, 1] - point[1], x[i, 2] - point[2]
        bx, by, bz = x[j, 0] - point[0], x[j, 1] - point[1], x[j, 2] - point[2]
        cx, cy, cz = x[k, 0] - point[0], x[k, 1] - point[1], x[k, 2] - point[2]
        a, b = math.sqrt(ax * ax + ay * ay + az * az), math.sqrt(bx * bx + by * by + bz * bz)
        c = math.sqrt(cx * cx + cy * cy + cz * cz)
        volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
        ab, bc, ca = ax * bx + ay * by + az * bz, bx * cx + by * cy + bz * cz, cx * ax + cy * ay + cz * az
        total += math.atan2(volume, a * b * c + ab * c + bc * a + ca * b)
    return total / (2.0 * math.pi)
