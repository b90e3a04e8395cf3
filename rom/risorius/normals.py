"""Smooth normals of a triangulated surface."""

from __future__ import annotations

import numba
import numpy as np
import numpy.typing as npt

Vectors = npt.NDArray[np.float32]


def vertex_normals(vertices: Vectors, triangles: npt.NDArray[np.int32], out: Vectors | None = None) -> Vectors:
    """Unit normals (n, 3) of vertices (n, 3), from the triangles (t, 3) about each, weighted by their areas.

    They are outward where triangles are counter-clockwise seen from outside, and zero where a vertex has no triangle,
    or none with an area. `out` receives them without another copy.
    """
    normals = np.empty_like(vertices) if out is None else out
    _write(vertices, triangles, normals)
    return normals


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _write(vertices, triangles, out):  # type: ignore[no-untyped-def]
    out[:] = 0.0
    for t in range(len(triangles)):
        i, j, k = np.uint64(triangles[t, 0]), np.uint64(triangles[t, 1]), np.uint64(triangles[t, 2])
        ax, ay, az = vertices[i, 0], vertices[i, 1], vertices[i, 2]
        bx, by, bz = vertices[j, 0] - ax, vertices[j, 1] - ay, vertices[j, 2] - az
        cx, cy, cz = vertices[k, 0] - ax, vertices[k, 1] - ay, vertices[k, 2] - az
        x, y, z = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
        for corner in (i, j, k):
            out[corner, 0] += x
            out[corner, 1] += y
            out[corner, 2] += z
    for n in range(len(out)):
        x, y, z = out[n, 0], out[n, 1], out[n, 2]
        size = np.sqrt(x * x + y * y + z * z)
        if size > 0.0:
            out[n, 0], out[n, 1], out[n, 2] = x / size, y / size, z / size


@numba.njit(cache=True, error_model="numpy")
def fan_normal(x, vertex, fan_starts, fans, triangles):  # type: ignore[no-untyped-def]
    """Normal of a vertex of x (n, 3) by the triangles around it, `fans` from fan_starts (n + 1,); of any length."""
    nx, ny, nz = 0.0, 0.0, 0.0
    for m in range(fan_starts[vertex], fan_starts[vertex + 1]):
        t = fans[m]
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
        vx, vy, vz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
        nx, ny, nz = nx + uy * vz - uz * vy, ny + uz * vx - ux * vz, nz + ux * vy - uy * vx
    return nx, ny, nz
