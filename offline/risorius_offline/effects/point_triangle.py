"""Distance between a point and a triangle, its derivatives, and how far both may move before they touch.

A pair is x (4, 3): the point, then the corners. The closest point of a convex feature of the triangle (the triangle,
an edge, a corner) is given by weights w (3,) of the corners; a corner outside the active face, edge or corner has
weight exactly zero. All in metres, in numba.
"""

from __future__ import annotations

import math

import numba
import numpy as np

compiled = numba.njit(cache=True, error_model="numpy")
inlined = numba.njit(inline="always", error_model="numpy")

TRIANGLE, EDGES, CORNERS = 0, (1, 2, 3), (4, 5, 6)
_MOST_ADVANCES = 100


@inlined
def _dot(a, b):  # type: ignore[no-untyped-def]
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def _distance_to(x, w):  # type: ignore[no-untyped-def]
    """Distance between the point and the point of weights w on the triangle."""
    square = 0.0
    for i in range(3):
        r = x[0, i] - (w[0] * x[1, i] + w[1] * x[2, i] + w[2] * x[3, i])
        square += r * r
    return math.sqrt(square)


@compiled
def _closest_on_edge(x, k, w):  # type: ignore[no-untyped-def]
    """Write the weights of the closest point of the edge from corner k to the next; return the distance."""
    following = (k + 1) % 3
    along, length = 0.0, 0.0
    for i in range(3):
        edge = x[1 + following, i] - x[1 + k, i]
        along += edge * (x[0, i] - x[1 + k, i])
        length += edge * edge
    s = along / length if length > 0.0 else 0.0
    s = min(max(s, 0.0), 1.0)
    w[:] = 0.0
    w[k], w[following] = 1.0 - s, s
    return _distance_to(x, w)


@compiled
def _closest_inside(x, w):  # type: ignore[no-untyped-def]
    """Write the weights of the foot of the point on the plane, if it lies inside; return whether it does."""
    a, b, p = x[2] - x[1], x[3] - x[1], x[0] - x[1]
    aa, ab, bb, pa, pb = _dot(a, a), _dot(a, b), _dot(b, b), _dot(p, a), _dot(p, b)
    determinant = aa * bb - ab * ab
    w[1] = (bb * pa - ab * pb) / determinant
    w[2] = (aa * pb - ab * pa) / determinant
    w[0] = 1.0 - w[1] - w[2]
    return determinant > 0.0 and w[0] > 0.0 and w[1] > 0.0 and w[2] > 0.0


@compiled
def closest_point(x, feature, w):  # type: ignore[no-untyped-def]
    """Write the weights of the closest point of a feature: 0 the triangle, 1 to 3 its edges, 4 to 6 its corners.

    Returns the distance. Edge k joins corner k - 1 to the next one. Flat triangles are no exception.
    """
    if feature >= CORNERS[0]:
        w[:] = 0.0
        w[feature - CORNERS[0]] = 1.0
        return _distance_to(x, w)
    if feature >= EDGES[0]:
        return _closest_on_edge(x, feature - EDGES[0], w)
    trial = np.empty(3)
    smallest = _closest_on_edge(x, 0, w)
    for k in range(1, 4):
        if k < 3:
            distance = _closest_on_edge(x, k, trial)
        else:
            distance = _distance_to(x, trial) if _closest_inside(x, trial) else math.inf
        if distance < smallest:
            smallest = distance
            w[:] = trial
    return smallest


@compiled
def add_gradient(x, w, slope, gradient):  # type: ignore[no-untyped-def]
    """Add slope dd/dx = slope n (1, -w) to gradient (12,), with n the direction from the closest point."""
    distance = _distance_to(x, w)
    for i in range(3):
        n = (x[0, i] - (w[0] * x[1, i] + w[1] * x[2, i] + w[2] * x[3, i])) / distance
        gradient[i] += slope * n
        for a in range(3):
            gradient[3 + 3 * a + i] -= slope * n * w[a]


@compiled
def add_hessian(x, w, slope, curvature, hessian):  # type: ignore[no-untyped-def]
    """Add curvature (dd/dx)(dd/dx) + slope d2d/dxdx to hessian (12, 12).

    d^2/2 is the minimum of |r|^2/2 over positions s on the active feature, so its second derivative is
    J^T J - B G^-1 B^T with r = J x, the feature's tangents e, G = e.e and B = J^T e + (de/dx)^T r: the implicit
    function theorem, for face, edge and corner alike.
    """
    j = np.array([1.0, -w[0], -w[1], -w[2]])
    r = x[0] - w[0] * x[1] - w[1] * x[2] - w[2] * x[3]
    distance = math.sqrt(_dot(r, r))
    ratio = slope / distance
    outer = (curvature - ratio) / (distance * distance)
    for a in range(4):
        for b in range(4):
            for i in range(3):
                hessian[3 * a + i, 3 * b + i] += ratio * j[a] * j[b]
                for k in range(3):
                    hessian[3 * a + i, 3 * b + k] += outer * j[a] * j[b] * r[i] * r[k]
    active = np.flatnonzero(w)
    tangents = len(active) - 1
    if tangents == 0:
        return
    e, B = np.zeros((2, 3)), np.zeros((2, 12))
    for t in range(tangents):
        first, other = 1 + active[0], 1 + active[t + 1]
        e[t] = x[other] - x[first]
        for i in range(3):
            for a in range(4):
                B[t, 3 * a + i] = j[a] * e[t, i]
            B[t, 3 * first + i] -= r[i]
            B[t, 3 * other + i] += r[i]
    aa, ab, bb = _dot(e[0], e[0]), _dot(e[0], e[1]), _dot(e[1], e[1]) if tangents == 2 else 1.0
    scale = -ratio / (aa * bb - ab * ab)
    for p in range(12):
        left, right = scale * (bb * B[0, p] - ab * B[1, p]), scale * (aa * B[1, p] - ab * B[0, p])
        for q in range(12):
            hessian[p, q] += left * B[0, q] + right * B[1, q]


@compiled
def safe_fraction(x, v, share, limit):  # type: ignore[no-untyped-def]
    """Largest fraction found of the motion v (4, 3), up to `limit`, that keeps `share` of the present distance.

    Conservative advancement: the plane through the closest point separates point and triangle, and the corner that
    closes in fastest along its normal bounds the time to contact from below. Exact for motion along the plane.
    """
    w, y = np.empty(3), x.copy()
    distance = closest_point(y, TRIANGLE, w)
    kept = share * distance
    time = 0.0
    for _ in range(_MOST_ADVANCES):
        advance = math.inf
        for a in range(1, 4):
            gap, closing = 0.0, 0.0
            for i in range(3):
                n = (y[0, i] - (w[0] * y[1, i] + w[1] * y[2, i] + w[2] * y[3, i])) / distance
                gap += n * (y[0, i] - y[a, i])
                closing -= n * (v[0, i] - v[a, i])
            if closing > 0.0:
                advance = min(advance, max(gap - kept, 0.0) / closing)
        if time + advance >= limit:
            return limit
        time += advance
        y[:] = x + time * v
        distance = closest_point(y, TRIANGLE, w)
        if distance <= 1.01 * kept:
            return time
    return time
