"""Contact of the skin of the lips, between the nodes that carry it, with the skin of the other lip: where they overlap.

Pairs of the seam (`lip_seam.py`) hold lips that close, turn and pucker apart. Lips that slide and roll past what they
faced at rest meet elsewhere: a point of the visible surface at the depth g behind the other lip has the energy
A/2 p0 d / 3 (g / d)^3, A its share of the surface, d DEPTH, half of it since either lip is looked at. Depths are those
to the nearest triangle of either sheet as it is now (`sheet_depth.py`), so nothing is paired; rest is free of contact.
Points beside the corners of the mouth, which at rest face nothing, take no part.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from risorius.jaw import FloatArray
from risorius.lip_sheets import LipSheets
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.discretisation import IntArray
from risorius_offline.effects.contact_surface import ContactSurface
from risorius_offline.effects.effect import NodeBlocks, Unobstructed
from risorius_offline.effects.lip_seam import facing_pairs
from risorius_offline.effects.point_triangle import add_hessian, compiled
from risorius_offline.effects.sheet_depth import SheetDepth
from risorius_offline.effects.skin_points import carriers

DEPTH, PRESSURE = 0.2e-3, 50e3  # metres; pascals there


class LipOverlap(Unobstructed):
    """The effect for an anatomy. weights (k, n): of the nodes that carry the k points of both lips."""

    def __init__(self, anatomy: Anatomy) -> None:
        skin = anatomy.visible_surface
        surface = ContactSurface.of_triangles(skin.points, skin.triangles)
        sheets = LipSheets.of(facing_pairs(surface), skin.points, skin.triangles)
        points = sheets.vertices
        self.weights, self._rest = sp.csr_matrix(skin.weights)[points], skin.points[points]
        self._scale = 0.5 * surface.areas[points] * PRESSURE / DEPTH**2
        numbered = replace(sheets, triangles=np.searchsorted(points, sheets.triangles))
        self._triangles = numbered.triangles
        self._depth = SheetDepth(self._rest, numbered)

    def set_parameters(self, parameters: FloatArray) -> None:
        """Do nothing: contact does not depend on muscles or pose weights."""

    def energy(self, u: FloatArray) -> float:
        """Joules; finite everywhere."""
        pairs, _, ways = self._overlaps(u)
        return self._energy(pairs, np.linalg.norm(ways, axis=1))

    def add_forces(self, u: FloatArray, forces: FloatArray) -> float:
        """Add dE/du in newtons to `forces` (n, 3) and return the energy."""
        pairs, shares, ways = self._overlaps(u)
        depths = np.linalg.norm(ways, axis=1)
        pressed = (self._scale[pairs[:, 0]] * depths)[:, None] * ways
        at_points = np.zeros_like(self._rest)
        np.add.at(at_points, pairs, shares[:, :, None] * pressed[:, None])
        forces += self.weights.T @ at_points
        return self._energy(pairs, depths)

    def second_derivatives(self, u: FloatArray, *, project: bool) -> NodeBlocks:
        """A block for every point in the other lip."""
        pairs, shares, _ = self._overlaps(u)
        if not len(pairs):
            return NodeBlocks.none()
        found = _hessians(self._places(u)[pairs], -shares[:, 1:], self._scale[pairs[:, 0]])
        if project:
            values, vectors = np.linalg.eigh(found)
            found = (vectors * np.maximum(values, 0.0)[:, None]) @ np.swapaxes(vectors, 1, 2)
        nodes, weights = carriers(self.weights[pairs.ravel()])
        count, most = len(pairs), nodes.shape[1]
        weights = weights.reshape(count, 4, most)
        blocks = np.einsum("kpa,kpiqj,kqb->kpaiqbj", weights, found.reshape(count, 4, 3, 4, 3), weights, optimize=True)
        return NodeBlocks(nodes.reshape(count, 4 * most), blocks.reshape(count, 12 * most, 12 * most))

    def _places(self, u: FloatArray) -> FloatArray:
        places: FloatArray = self._rest + self.weights @ u
        return places

    def _overlaps(self, u: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
        """Points (c, 4), the one that is in the other lip and the corners nearest to it, and their shares in the way.

        The way (c, 3) leads from the nearest point to it: the sum of the places times shares (c, 4).
        """
        places = self._places(u)
        points, found, weights = self._depth.behind(places)
        pairs = np.column_stack([points, self._triangles[found]])
        shares = np.column_stack([np.ones(len(pairs)), -weights])
        return pairs, shares, np.einsum("ka,kai->ki", shares, places[pairs])

    def _energy(self, pairs: IntArray, depths: FloatArray) -> float:
        return float(self._scale[pairs[:, 0]] @ depths**3) / 3.0


@compiled
def _hessians(places, weights, scale):  # type: ignore[no-untyped-def]
    """Second derivatives (c, 12, 12) of scale / 3 depth^3 at places (c, 4, 3), with the weights of nearest points."""
    hessians = np.zeros((len(places), 12, 12))
    for number in range(len(places)):
        w, pair = weights[number], places[number]
        way = pair[0] - w[0] * pair[1] - w[1] * pair[2] - w[2] * pair[3]
        depth = np.sqrt(way @ way)
        add_hessian(pair, w, scale[number] * depth**2, 2.0 * scale[number] * depth, hessians[number])
    return hessians
