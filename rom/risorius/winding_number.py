"""Generalised winding number of triangles around a point (Jacobson et al. 2013): one inside, zero outside.

Where the surface is open it is what the triangles cover of the whole sphere of directions, between the two. Halves of
their solid angles are those of complex numbers, which are multiplied: a sum of angles without a function for each.
"""

from __future__ import annotations

import math

import numba


@numba.njit(cache=True, error_model="numpy")
def winding_number(point, x, triangles):  # type: ignore[no-untyped-def]
    """Winding number at a point (3,) of triangles (m, 3) of vertices x (n, 3), by solid angles (Van Oosterom 1983)."""
    turned_x, turned_y, turns = 1.0, 0.0, 0
    for t in range(len(triangles)):
        i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        ax, ay, az = x[i, 0] - point[0], x[i, 1] - point[1], x[i, 2] - point[2]
        bx, by, bz = x[j, 0] - point[0], x[j, 1] - point[1], x[j, 2] - point[2]
        cx, cy, cz = x[k, 0] - point[0], x[k, 1] - point[1], x[k, 2] - point[2]
        a, b = math.sqrt(ax * ax + ay * ay + az * az), math.sqrt(bx * bx + by * by + bz * bz)
        c = math.sqrt(cx * cx + cy * cy + cz * cz)
        volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
        ab, bc, ca = ax * bx + ay * by + az * bz, bx * cx + by * cy + bz * cz, cx * ax + cy * ay + cz * az
        angle_x = a * b * c + ab * c + bc * a + ca * b
        scale = 1.0 / max(math.sqrt(angle_x * angle_x + volume * volume), 1e-300)
        angle_x, angle_y = scale * angle_x, scale * volume
        before, turned_y = turned_y, turned_x * angle_y + turned_y * angle_x
        turned_x = turned_x * angle_x - before * angle_y
        if before >= 0.0 and angle_y >= 0.0 and turned_y < 0.0:
            turns += 1
        elif before < 0.0 and angle_y < 0.0 and turned_y >= 0.0:
            turns -= 1
    return math.atan2(turned_y, turned_x) / (2.0 * math.pi) + turns
