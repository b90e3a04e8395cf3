"""Surfaces that the deep side of the face slides on: upper and lower teeth with gums and bone, and the eyeballs."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.anatomy.anatomy import Surface
from risorius_offline.discretisation import IntArray
from risorius_offline.head.border import border_edges
from risorius_offline.head.skin import EYE_CENTRE
from risorius_offline.head.skull import GLOBE

BITE = -45.6  # height at which upper and lower teeth meet
PAST = 5.0  # how far they reach past each other, so that no tissue gets between them
TEETH = (45.0, 46.0)  # they lie within this x and in front of this z
THROAT = -84.0
SUBDIVISIONS = 3


def bones(deep: FloatArray, triangles: IntArray) -> dict[str, Surface]:
    """Bones in millimetres. deep (n, 3) nodes of the deep side with their triangles (m, 3).

    Teeth are behind the slit between the lips, too.
    """
    triangles = np.concatenate([triangles, _behind_the_lips(deep, triangles)])
    x, y, z = deep[triangles].mean(axis=1).T
    past = np.where((np.abs(x) < TEETH[0]) & (z > TEETH[1]), PAST, 0.0)
    upper, lower = y > BITE - past, (y <= BITE + past) & (y > THROAT)
    found = {"cranium": _part(deep, triangles[upper]), "jaw": _part(deep, triangles[lower])}
    for side, sign in (("left", 1.0), ("right", -1.0)):
        points, faces = _sphere()
        found[f"{side}_eyeball"] = Surface(points * GLOBE.radii[0] + np.array(EYE_CENTRE) * [sign, 1.0, 1.0], faces)
    return found


def _behind_the_lips(deep: FloatArray, triangles: IntArray) -> IntArray:
    """Triangles (k, 3) that close the slit between the lips: mirror images, wound as those that they join."""
    border = border_edges(triangles)
    following = dict(border.tolist())
    entering = border[(deep[border[:, 0], 0] == 0.0) & (deep[border[:, 1], 0] > 0.0), 0]
    left = _to_midline(deep, following, entering[deep[entering, 2].argmax()])
    right = _to_midline(deep, following, left[-1])
    image = dict(zip(left, reversed(right), strict=True))
    found, first, last = [], 0, len(left) - 1
    while last - first > 1:
        found.append((left[first + 1], left[first], left[last]))
        if last - first > 2:
            found.append((left[last], left[last - 1], left[first + 1]))
        first, last = first + 1, last - 1
    return np.array(found + [(image[c], image[b], image[a]) for a, b, c in found])


def _to_midline(deep: FloatArray, following: Mapping[int, int], start: int) -> list[int]:
    """Nodes of a border from one in the midline to the next one there, both included."""
    nodes = [int(start), following[int(start)]]
    while deep[nodes[-1], 0] != 0.0:
        nodes.append(following[nodes[-1]])
    return nodes


def _part(points: FloatArray, triangles: IntArray) -> Surface:
    used, renumbered = np.unique(triangles, return_inverse=True)
    return Surface(points[used], renumbered.reshape(-1, 3))


def _sphere() -> tuple[FloatArray, IntArray]:
    """Unit sphere from a subdivided octahedron, outward triangles."""
    points = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float64)
    triangles = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
    for _ in range(SUBDIVISIONS):
        corners = points[triangles]
        middles = 0.5 * (corners + np.roll(corners, -1, axis=1))
        a, b, c = corners.transpose(1, 0, 2)
        ab, bc, ca = middles.transpose(1, 0, 2)
        soup = np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
        points, inverse = np.unique(soup.reshape(-1, 3).round(12), axis=0, return_inverse=True)
        triangles = inverse.reshape(-1, 3)
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    return points, triangles
