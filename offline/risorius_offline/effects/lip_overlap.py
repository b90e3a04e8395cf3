"""Contact of the skin of the lips, between the nodes that carry it, with the skin of the other lip: where they overlap.

Pairs of the seam (`lip_seam.py`) hold lips apart that close, turn and pucker. Lips that slide and roll past what they
faced at rest meet elsewhere. What is behind the other lip where an equilibrium is found is paired with the triangle
that is nearest to it there (`risorius.lip_search`), and the equilibrium is looked for again. A pair whose point is at
the depth g behind the plane of its triangle presses, for half of the point's share of the surface, by

    p = p0 (g / d)^2 for g < d,    p0 (3 - 2 d / g) beyond

twice: on the point and on the triangle. The derivative is continuous, and p does not grow without end: lips that are
millimetres in each other come apart without tearing what carries them. Rest is free of contact.
"""

from __future__ import annotations

import math

import numpy as np
import scipy.sparse as sp

from risorius.jaw import FloatArray
from risorius.lip_search import LipSearch
from risorius.lip_sheets import LipSheets
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.discretisation import IntArray
from risorius_offline.effects.contact_surface import ContactSurface
from risorius_offline.effects.effect import NO_CONTACTS, NodeBlocks, Unobstructed
from risorius_offline.effects.lip_seam import facing_pairs
from risorius_offline.effects.plane_height import PlaneHeight
from risorius_offline.effects.skin_points import carriers

DEPTH, PRESSURE = 0.2e-3, 50e3  # metres; pascals there
DEEPEST = 5e-3  # metres; what is farther behind a lip is not in it


class LipOverlap(Unobstructed):
    """The effect for an anatomy. weights (k, n): of the nodes that carry the k points of both lips."""

    def __init__(self, anatomy: Anatomy) -> None:
        skin = anatomy.visible_surface
        surface = ContactSurface.of_triangles(skin.points, skin.triangles)
        sheets = LipSheets.of(facing_pairs(surface), skin.points, skin.triangles.astype(np.int32))
        points = sheets.vertices
        self.weights, self._rest = sp.csr_matrix(skin.weights)[points], skin.points[points]
        self._areas = 0.5 * surface.areas[points]
        self._search = LipSearch(sheets)
        at_rest = self._search.nearest(self._rest, np.arange(len(points)), math.inf)
        self._seeing = at_rest.points[~at_rest.at_rim]
        self._pairs = NO_CONTACTS

    def set_parameters(self, parameters: FloatArray) -> None:
        """Do nothing: contact does not depend on muscles or pose weights."""

    @property
    def contacts(self) -> IntArray:
        """Pairs (c, 4) of a point and the corners of the triangle that it presses on."""
        return self._pairs

    def search_contacts(self, u: FloatArray) -> IntArray:
        """Pairs (c, 4) of a point that is behind the other lip at u, and the corners of the triangle nearest to it.

        That is, behind all triangles that meet at the nearest place, and in front of the nearest at rest: what is
        behind that has tissue in between. What is at the rim of the other lip is beside it; at rest such points take no
        part.
        """
        near = self._search.nearest(self._places(u), self._seeing, DEEPEST)
        behind = (near.greatest < 0.0) & ~near.at_rim
        behind &= self._search.in_front(self._rest, near.points, near.triangles)
        return np.column_stack([near.points, self._search.corners[near.triangles]])[behind]

    def hold_contacts(self, contacts: IntArray) -> None:
        """Hold pairs (c, 4) in place of those before."""
        self._pairs = contacts

    def missed_depth(self, u: FloatArray, contacts: IntArray) -> float:
        """Metres by which a point is deeper at u by `contacts` (c, 4) than by the pair of it that is held."""
        held = np.zeros(len(self._rest))
        np.maximum.at(held, self._pairs[:, 0], self._depths(self._heights(u, self._pairs)))
        return float((self._depths(self._heights(u, contacts)) - held[contacts[:, 0]]).max(initial=0.0))

    def energy(self, u: FloatArray) -> float:
        """Joules; finite everywhere."""
        if not len(self._pairs):
            return 0.0
        return self._energy(self._depths(self._heights(u, self._pairs)))

    def add_forces(self, u: FloatArray, forces: FloatArray) -> float:
        """Add dE/du in newtons to `forces` (n, 3) and return the energy."""
        if not len(self._pairs):
            return 0.0
        heights = self._heights(u, self._pairs)
        depths = self._depths(heights)
        pressed = -self._areas[self._pairs[:, 0]] * pressure(depths)
        at_points = np.zeros_like(self._rest)
        np.add.at(at_points, self._pairs, pressed[:, None, None] * heights.gradients)
        forces += self.weights.T @ at_points
        return self._energy(depths)

    def second_derivatives(self, u: FloatArray, *, project: bool) -> NodeBlocks:
        """Blocks of all pairs, zero where they do not touch, so that their pattern stays."""
        if not len(self._pairs):
            return NodeBlocks.none()
        heights, areas = self._heights(u, self._pairs), self._areas[self._pairs[:, 0]]
        depths, gradient = self._depths(heights), heights.gradients.reshape(-1, 12)
        found = (areas * pressure_slope(depths))[:, None, None] * gradient[:, :, None] * gradient[:, None, :]
        if not project:
            found -= (areas * pressure(depths))[:, None, None] * heights.hessians
        nodes, weights = carriers(self.weights[self._pairs.ravel()])
        count, most = len(found), nodes.shape[1]
        weights = weights.reshape(count, 4, most)
        blocks = np.einsum("kpa,kpiqj,kqb->kpaiqbj", weights, found.reshape(count, 4, 3, 4, 3), weights, optimize=True)
        return NodeBlocks(nodes.reshape(count, 4 * most), blocks.reshape(count, 12 * most, 12 * most))

    def _places(self, u: FloatArray) -> FloatArray:
        places: FloatArray = self._rest + self.weights @ u
        return places

    def _heights(self, u: FloatArray, pairs: IntArray) -> PlaneHeight:
        return PlaneHeight.of(self._places(u)[pairs])

    def _depths(self, heights: PlaneHeight) -> FloatArray:
        return np.maximum(-heights.values, 0.0)

    def _energy(self, depths: FloatArray) -> float:
        return float(self._areas[self._pairs[:, 0]] @ work(depths))


def pressure(depths: FloatArray) -> FloatArray:
    """Pascals at depths (c,), metres."""
    beyond = np.maximum(depths / DEPTH, 1.0)
    result: FloatArray = PRESSURE * np.where(depths < DEPTH, (depths / DEPTH) ** 2, 3.0 - 2.0 / beyond)
    return result


def pressure_slope(depths: FloatArray) -> FloatArray:
    """Derivative of the pressure, Pa/m."""
    shallow, beyond = np.minimum(depths / DEPTH, 1.0), np.maximum(depths / DEPTH, 1.0)
    result: FloatArray = 2.0 * PRESSURE / DEPTH * shallow / beyond**2
    return result


def work(depths: FloatArray) -> FloatArray:
    """Integral of the pressure from no depth on, J/m2."""
    shallow, beyond = np.minimum(depths / DEPTH, 1.0), np.maximum(depths / DEPTH, 1.0)
    result: FloatArray = PRESSURE * DEPTH * (shallow**3 / 3.0 + 3.0 * (beyond - 1.0) - 2.0 * np.log(beyond))
    return result
