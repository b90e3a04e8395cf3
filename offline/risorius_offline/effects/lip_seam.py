"""Contact of lips with each other along the seam where they meet at rest: a one-sided, frictionless, cheap penalty.

Every node p of a free boundary that faces another one nearby at rest is paired for good with the triangle it faces, or
shared among those of several that are equally near. The gap g is its height over the plane of the triangle as that is
now, which turns with the lip and has no end, and

    E = sum over pairs  A_p/2 p0 d / 3 ((d - g) / d)^3  for g < d, otherwise 0

is twice continuously differentiable and finite everywhere: it shortens no step, and a node behind its triangle is
pushed back the way it came. d is the gap tolerance, or the gap at rest where that is less: rest is free of contact.
Half of the area: a contact is seen from both sides. Projected second derivatives leave out those of the gap.

Pairs hold for lips that close, tighten, turn, slide and pucker by less than their own thickness; what sees everything
that may touch is `lip_contact.py`.
"""

from __future__ import annotations

import numpy as np

from risorius.jaw import FloatArray
from risorius.mechanics.one_sided import OneSidedSprings
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.discretisation import IntArray
from risorius_offline.effects.contact_surface import ContactSurface
from risorius_offline.effects.effect import NodeBlocks, Unobstructed
from risorius_offline.effects.pairs import PairList
from risorius_offline.effects.plane_height import PlaneHeight
from risorius_offline.effects.point_triangle import TRIANGLE, closest_point, compiled

GAP_TOLERANCE, LEAST_TOLERANCE = 0.5e-3, 0.2e-3  # metres; the least is that of corners, where lips touch at rest
PRESSURE = 50e3  # Pa, at zero gap
REACH = 2.5e-3  # between faces at rest, metres
FACING = -0.7  # cosine of the angle between normals of faces that can meet
EQUALLY = 1e-9  # metres by which the nearest triangles may differ: a foot on an edge, a node in the plane of symmetry


class LipSeam(Unobstructed):
    """The effect for an anatomy. nodes (k, 4): of the pairs, first the one that faces the other three."""

    def __init__(self, anatomy: Anatomy) -> None:
        self._node_count = len(anatomy.points)
        surface = ContactSurface.of(anatomy)
        pairs = facing_pairs(surface)
        own, across = pairs.T
        self.nodes = surface.nodes[np.column_stack([own, surface.triangles[across]])]
        self._rest = anatomy.points[self.nodes]
        gaps = PlaneHeight.of(self._rest).values
        self._tolerance = np.clip(gaps, LEAST_TOLERANCE, GAP_TOLERANCE)
        self._onset = np.minimum(gaps, self._tolerance)
        shared = np.bincount(own)[own]
        self._scale = 0.5 * surface.areas[own] / shared * PRESSURE / self._tolerance**2

    def set_parameters(self, parameters: FloatArray) -> None:
        """Do nothing: contact does not depend on muscles or pose weights."""

    def gaps(self, u: FloatArray) -> FloatArray:
        """Gap (k,) of every pair, metres; negative where lips pass through each other."""
        return self._heights(u).values

    def energy(self, u: FloatArray) -> float:
        """Joules; finite everywhere."""
        return float(self._scale @ self._overlap(self._heights(u)) ** 3) / 3.0

    def add_forces(self, u: FloatArray, forces: FloatArray) -> float:
        """Add dE/du in newtons to `forces` (n, 3) and return the energy."""
        heights = self._heights(u)
        overlap = self._overlap(heights)
        pressed = -self._scale * overlap**2
        np.add.at(forces, self.nodes, pressed[:, None, None] * heights.gradients)
        return float(self._scale @ overlap**3) / 3.0

    def second_derivatives(self, u: FloatArray, *, project: bool) -> NodeBlocks:
        """Blocks of all pairs, zero without contact, so that their pattern stays."""
        heights = self._heights(u)
        overlap = self._overlap(heights)
        blocks, touching = np.zeros((len(self.nodes), 12, 12)), np.flatnonzero(overlap > 0.0)
        heights, overlap, scale = heights.of_some(touching), overlap[touching], self._scale[touching]
        gradient = heights.gradients.reshape(len(touching), 12)
        found = (2.0 * scale * overlap)[:, None, None] * gradient[:, :, None] * gradient[:, None, :]
        if not project:
            found -= (scale * overlap**2)[:, None, None] * heights.hessians
        blocks[touching] = found
        return NodeBlocks(self.nodes, blocks)

    def springs_at_rest(self, reach: float) -> OneSidedSprings:
        """What stops lips at rest that come nearer to each other by less than `reach` metres."""
        heights = PlaneHeight.of(self._rest)
        ways = heights.values - self._onset
        near = np.flatnonzero(ways < reach)
        return OneSidedSprings.between(
            self.nodes[near], heights.gradients[near], self._node_count, ways[near], self._scale[near]
        )

    def _heights(self, u: FloatArray) -> PlaneHeight:
        return PlaneHeight.of(self._rest + u[self.nodes])

    def _overlap(self, heights: PlaneHeight) -> FloatArray:
        return np.maximum(self._onset - heights.values, 0.0)


def facing_pairs(surface: ContactSurface) -> IntArray:
    """Pairs (k, 2) of a free node and a triangle it faces within REACH at rest."""
    candidates = PairList(surface, np.flatnonzero(~surface.bone), REACH, 0.0).at(surface.points)
    normals = _normals(surface.points, surface.triangles)
    pairs: IntArray = _facing(
        surface.points, candidates, surface.triangles, normals, surface.bone, surface.fans, surface.fan_starts
    )
    return pairs


def _normals(points: FloatArray, triangles: IntArray) -> FloatArray:
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    normal = np.cross(b - a, c - a)
    result: FloatArray = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    return result


@compiled
def _facing(x, pairs, triangles, normals, bone, fans, fan_starts):  # type: ignore[no-untyped-def]
    """Nearest triangles in front that each node faces, pairs (k, 2).

    A node faces what is opposite to one of its own triangles. Prescribed nodes take no part.
    """
    nearest, distances = np.full(len(x), REACH), np.full(len(pairs), np.inf)
    pair, foot = np.empty((4, 3)), np.empty(3)
    for number, (p, t) in enumerate(pairs):
        a, b, c = triangles[t]
        if bone[p] or bone[a] or bone[b] or bone[c]:
            continue
        opposite = 1.0
        for k in range(fan_starts[p], fan_starts[p + 1]):
            opposite = min(opposite, normals[fans[k]] @ normals[t])
        if opposite > FACING or normals[t] @ (x[p] - x[a]) < 0.0:
            continue
        pair[0], pair[1], pair[2], pair[3] = x[p], x[a], x[b], x[c]
        distances[number] = closest_point(pair, TRIANGLE, foot)
        nearest[p] = min(nearest[p], distances[number])
    return pairs[distances < nearest[pairs[:, 0]] + EQUALLY]
