"""Contact of the tissue's surface with itself: lips with each other, cheeks with lips. One-sided and frictionless.

A barrier on the distance d between boundary nodes and boundary triangles (Li et al. 2020, Incremental Potential
Contact), per area that a node stands for at rest, so that it converges with the mesh (Li et al. 2023, Convergent
Incremental Potential Contact):

    E = sum over nodes p  A_p/2 k_p ( sum over triangles b(d) - sum over edges b(d) + sum over corners b(d) )
    b(d) = -(d - g_p)^2 ln(d / g_p)  for 0 < d < g_p, otherwise 0

Edges and corners that triangles share are taken off and put back, so that a node over a flat place feels one barrier
wherever the edges lie beneath it. Contact begins at the gap g_p and the distance never reaches zero. g_p is the gap
tolerance, or CLEARANCE of the node's own distance at rest where that is less: rest is free of contact. A node for which
that leaves less than LEAST_GAP of the tolerance lies in a fold of the mesh (a corner of the mouth) and sees nothing.
Half of the area: a contact is seen from both sides.

Edges do not see each other: two of them may cross, by less than a surface's sagitta over an edge.
"""

from __future__ import annotations

import math

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.effects.contact_surface import ContactSurface, multiplicity
from risorius_offline.effects.effect import NodeBlocks, WithoutContactPairs
from risorius_offline.effects.pairs import PairList
from risorius_offline.effects.point_triangle import (
    CORNERS,
    TRIANGLE,
    add_gradient,
    add_hessian,
    closest_point,
    compiled,
    inlined,
    safe_fraction,
)

GAP_TOLERANCE = 0.2e-3
PRESSURE_AT_HALF_GAP = 10e3
CLEARANCE, LEAST_GAP = 0.9, 0.5
# A step keeps this share of every distance.
_KEPT_SHARE = 0.1
_MARGIN = 0.5e-3
# Longer motions are followed piece by piece, since the boxes that they sweep hold too many pairs; to the longest one.
_LONGEST_SWEEP, _LONGEST_MOTION = 4e-3, 0.2


class LipContact(WithoutContactPairs):
    """The effect for an anatomy; gap_tolerance in metres is where contact begins.

    blind: numbers, in the surface of the anatomy, of the nodes that see nothing.
    """

    def __init__(self, anatomy: Anatomy, gap_tolerance: float = GAP_TOLERANCE) -> None:
        surface = ContactSurface.of(anatomy)
        everyone = np.arange(len(surface.nodes))
        at_rest = PairList(surface, everyone, gap_tolerance / CLEARANCE, 0.0).at(surface.points)
        self._surface = surface
        room, least = CLEARANCE * nearest(surface.points, at_rest, surface.triangles), LEAST_GAP * gap_tolerance
        self.blind = np.flatnonzero(room < least)
        self._pairs = PairList(surface, np.flatnonzero(room >= least), gap_tolerance, _MARGIN)
        self._gaps = np.clip(room, least, gap_tolerance)
        # b'(g/2) = -(ln 2 + 1/2) g: every node presses alike at half of its gap.
        self._weights = 0.5 * surface.areas * PRESSURE_AT_HALF_GAP / ((math.log(2.0) + 0.5) * self._gaps)
        self._topology = (surface.triangles, surface.bone, surface.across, surface.fans, surface.fan_starts)

    def set_parameters(self, parameters: FloatArray) -> None:
        """Contact does not depend on muscles or pose weights."""

    def energy(self, u: FloatArray) -> float:
        """Joules; infinite where a node lies on a triangle."""
        return float(self._integrate(u, np.empty((0, 3))))

    def add_forces(self, u: FloatArray, forces: FloatArray) -> float:
        """Add dE/du to forces (n, 3) in newtons; returns the energy."""
        own = np.zeros_like(self._surface.points)
        energy = self._integrate(u, own)
        forces[self._surface.nodes] += own
        return float(energy)

    def second_derivatives(self, u: FloatArray, *, project: bool) -> NodeBlocks:
        """A block for every node in contact."""
        x = self._positions(u)
        touching = touching_pairs(x, self._pairs.at(x), self._gaps, self._surface.triangles)
        nodes, matrices = contact_blocks(x, touching, self._gaps, self._weights, *self._topology, project)
        return NodeBlocks(self._surface.nodes[nodes], matrices)

    def admits(self, u: FloatArray) -> bool:
        """Whether no node meets a triangle on the straight way there from rest."""
        return self.largest_step(np.zeros_like(u), u) == 1.0

    def push_out(self, u: FloatArray) -> None:
        """Nothing: surfaces that went through each other do not tell which way is out."""

    def largest_step(self, u: FloatArray, direction: FloatArray) -> float:
        """Fraction in (0, 1] of a direction on which no node meets a triangle; at most 200 mm are allowed."""
        x, motion = self._positions(u), direction[self._surface.nodes]
        length = float(np.linalg.norm(motion, axis=1).max())
        if not math.isfinite(length):
            return 1.0  # nothing of it has a finite energy
        if length > _LONGEST_MOTION:
            share = _LONGEST_MOTION / length
            return share * self.largest_step(u, share * direction)
        pieces = max(1, math.ceil(length / _LONGEST_SWEEP))
        motion = motion / pieces
        for piece in range(pieces):
            pairs = self._pairs.swept(x, motion)
            fraction = smallest_fraction(x, motion, pairs, self._surface.triangles, _KEPT_SHARE)
            if fraction < 1.0:
                return float((piece + fraction) / pieces)
            x = x + motion
        return 1.0

    def smallest_gap(self, u: FloatArray) -> float:
        """Smallest distance in metres of a node that is in contact; infinite when none is."""
        x = self._positions(u)
        distances = nearest(x, self._pairs.at(x), self._surface.triangles)
        return float(np.min(distances[distances < self._gaps], initial=np.inf))

    def _positions(self, u: FloatArray) -> FloatArray:
        return self._surface.points + u[self._surface.nodes]

    def _integrate(self, u: FloatArray, forces: FloatArray) -> float:
        x = self._positions(u)
        return contact_energy(x, self._pairs.at(x), self._gaps, self._weights, *self._topology, forces)


@inlined
def barrier(d, gap):  # type: ignore[no-untyped-def]
    """b(d) of Li et al. 2020 on the distance itself, its first and second derivative, for 0 < d < gap."""
    log, beyond = math.log(d / gap), d - gap
    value = -beyond * beyond * log
    slope = -2.0 * beyond * log - beyond * beyond / d
    return value, slope, -2.0 * log - 4.0 * beyond / d + (beyond / d) ** 2


@inlined
def _gather(source, triangles, p, t, pair):  # type: ignore[no-untyped-def]
    """Write the rows of node p and of the corners of triangle t into pair (4, 3)."""
    for i in range(3):
        pair[0, i] = source[p, i]
        for a in range(3):
            pair[1 + a, i] = source[triangles[t, a], i]


@compiled
def nearest(x, pairs, triangles):  # type: ignore[no-untyped-def]
    """Distance (b,) of every node to the nearest triangle of its pairs; infinite without pairs."""
    distances = np.full(len(x), np.inf)
    pair, w = np.empty((4, 3)), np.empty(3)
    for p, t in pairs:
        _gather(x, triangles, p, t, pair)
        distances[p] = min(distances[p], closest_point(pair, TRIANGLE, w))
    return distances


@compiled
def smallest_fraction(x, motion, pairs, triangles, share):  # type: ignore[no-untyped-def]
    """Largest fraction of motion (b, 3), up to 1, on which every pair keeps a share of its distance."""
    fraction = 1.0
    pair, v = np.empty((4, 3)), np.empty((4, 3))
    for p, t in pairs:
        _gather(x, triangles, p, t, pair)
        _gather(motion, triangles, p, t, v)
        fraction = safe_fraction(pair, v, share, fraction)
    return fraction


@compiled
def contact_energy(x, pairs, gaps, weights, triangles, bone, across, fans, fan_starts, forces):  # type: ignore[no-untyped-def]
    """Energy at positions x (b, 3); adds the forces (b, 3) unless that array is empty."""
    total = 0.0
    pair, w, gradient = np.empty((4, 3)), np.empty(3), np.empty(12)
    for p, t in pairs:
        _gather(x, triangles, p, t, pair)
        distance = closest_point(pair, TRIANGLE, w)
        if distance <= 0.0:
            return math.inf
        if not distance < gaps[p]:
            continue
        gradient[:] = 0.0
        for feature in range(CORNERS[-1] + 1):
            count = multiplicity(p, t, feature, triangles, bone, across, fans, fan_starts)
            if count == 0.0:
                continue
            distance = closest_point(pair, feature, w)
            if distance < gaps[p]:
                value, slope, _ = barrier(distance, gaps[p])
                total += count * weights[p] * value
                add_gradient(pair, w, count * weights[p] * slope, gradient)
        if len(forces):
            for i in range(3):
                forces[p, i] += gradient[i]
                for a in range(3):
                    forces[triangles[t, a], i] += gradient[3 + 3 * a + i]
    return total


@compiled
def touching_pairs(x, pairs, gaps, triangles):  # type: ignore[no-untyped-def]
    """Pairs (c, 2) that are nearer than the node's gap."""
    pair, w = np.empty((4, 3)), np.empty(3)
    chosen = np.zeros(len(pairs), dtype=np.bool_)
    for number in range(len(pairs)):
        p, t = pairs[number]
        _gather(x, triangles, p, t, pair)
        chosen[number] = closest_point(pair, TRIANGLE, w) < gaps[p]
    return pairs[chosen]


@compiled
def stencils(touching, triangles):  # type: ignore[no-untyped-def]
    """Block and places in it of the nodes of pairs sorted by node: owner (c,), places (c, 4), nodes (blocks, m).

    A block is a node with all corners that it touches; blocks with fewer nodes than m repeat their first one.
    """
    owner, places = np.zeros(len(touching), dtype=np.int64), np.zeros((len(touching), 4), dtype=np.int64)
    most = 1 + 3 * (np.bincount(touching[:, 0]).max() if len(touching) else 0)
    found, sizes = np.empty((len(touching), most), dtype=np.int64), np.zeros(len(touching), dtype=np.int64)
    block = -1
    for number in range(len(touching)):
        p, t = touching[number]
        if number == 0 or touching[number - 1, 0] != p:
            block += 1
            found[block] = p
            sizes[block] = 1
        owner[number] = block
        for a in range(3):
            place = 0
            while place < sizes[block] and found[block, place] != triangles[t, a]:
                place += 1
            if place == sizes[block]:
                found[block, place] = triangles[t, a]
                sizes[block] += 1
            places[number, 1 + a] = place
    return owner, places, found[: block + 1, : max(1, sizes.max() if len(sizes) else 1)]


@compiled
def contact_blocks(x, touching, gaps, weights, triangles, bone, across, fans, fan_starts, project):  # type: ignore[no-untyped-def]
    """Nodes (k, m) and second derivatives (k, 3 m, 3 m), one block for every node in contact."""
    owner, places, nodes = stencils(touching, triangles)
    blocks = np.zeros((len(nodes), 3 * nodes.shape[1], 3 * nodes.shape[1]))
    pair, w, hessian = np.empty((4, 3)), np.empty(3), np.empty((12, 12))
    for number in range(len(touching)):
        p, t = touching[number]
        _gather(x, triangles, p, t, pair)
        hessian[:] = 0.0
        for feature in range(CORNERS[-1] + 1):
            count = multiplicity(p, t, feature, triangles, bone, across, fans, fan_starts)
            distance = closest_point(pair, feature, w)
            if count != 0.0 and distance < gaps[p]:
                _, slope, curvature = barrier(distance, gaps[p])
                factor = count * weights[p]
                add_hessian(pair, w, factor * slope, factor * curvature, hessian)
        block = blocks[owner[number]]
        for a in range(4):
            for b in range(4):
                row, column = 3 * places[number, a], 3 * places[number, b]
                block[row : row + 3, column : column + 3] += hessian[3 * a : 3 * a + 3, 3 * b : 3 * b + 3]
    if project:
        for block in blocks:
            values, vectors = np.linalg.eigh(block)
            block[:] = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return nodes, blocks
