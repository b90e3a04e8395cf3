"""The surer and slower look at lips: of the points at which the quick one cannot be trusted."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from risorius.adjacency import vertex_fans
from risorius.effects.contact_doubt import trust_others
from risorius.effects.contact_patches import Patches
from risorius.effects.contact_planes import TOLD
from risorius.effects.contact_proof import prove
from risorius.effects.contact_tables import ContactTables
from risorius.effects.lane_blocks import NOWHERE, blocks_of, turn_planes
from risorius.effects.lip_doubt import LipDoubt
from risorius.effects.retreat import Retreat
from risorius.effects.skin_around import place_skin
from risorius.jaw import FloatArray
from risorius.lip_sheets import on_border
from risorius.vector_lanes import LANES
from risorius.winding_number import place_corners

Numbers = npt.NDArray[np.int32]


class LipProof:
    """Looks at vertices of the lips. Not thread-safe: it owns what it works with.

    side_of (n,): lips that vertices are on, 0 or 1. rest (n, 3): where they are at rest. vertices (l,): of the lips;
    numbers (k,): of the points of the tables among them. state: triangles (l,) near these, working space, gaps (l,) and
    ways out (l, 3).
    """

    def __init__(self, tables: ContactTables, side_of: Numbers, retreat: Retreat) -> None:
        t, sign = tables, float(tables.orientation[0])
        self.rest = retreat.rest
        side_of_triangle = side_of[t.triangles[:, 0]]
        self.vertices = np.unique(t.triangles[side_of_triangle >= 0]).astype(np.int32)
        sides, count = side_of[self.vertices], len(self.vertices)
        patches = Patches.of(t.shares[self.vertices], sides)
        centres = self.rest[t.triangles].mean(axis=1)
        fans, fan_starts = vertex_fans(retreat.skin, len(side_of))  # lips end at their corners, skin goes on
        self._points = (
            self.vertices, sides, patches.order, patches.starts, retreat.skin, fan_starts.astype(np.int32),
            fans.astype(np.int32), np.full(count, np.nan),
        )  # fmt: skip
        border = on_border(t.triangles, t.across, len(side_of))
        around = retreat.around
        skin, of_rest = (around.triangles, around.edges, around.apex), np.empty((9, around.size), np.float32)
        place_skin(self.rest, *skin, of_rest)
        told = np.zeros(count, np.int8)
        self._surface = t.triangles, t.across, t.planes, sign, border, (of_rest, np.empty_like(of_rest), told, *skin)
        members, split = blocks_of(centres, side_of_triangle)
        grouped = np.ascontiguousarray(t.triangles[np.maximum(members, 0).ravel()])
        corners, sizes = np.zeros((9, members.size), np.float32), np.zeros(members.size, np.float32)
        turned, faced = np.zeros((2, 4, members.size), np.float32)
        place_corners(self.rest, grouped, corners)
        turn_planes(corners, sign, sizes, faced)
        self._blocks = members, grouped, faced, split
        self.numbers = np.searchsorted(self.vertices, t.vertices).astype(np.int32)
        self._doubt = LipDoubt(self.vertices, self.numbers, sides, patches, self.rest)
        self._work = (
            self._doubt.spheres[3], np.full((4, len(members)), NOWHERE, np.float32), corners, sizes,
            turned, np.zeros(len(members), np.int32), np.zeros((4, len(members) + LANES), np.float32),
            np.zeros(3), np.zeros(3, np.float32),
        )  # fmt: skip
        facing = _facing(centres, side_of_triangle, self.rest[self.vertices], sides)
        self.state = facing, np.zeros(count, np.int32), np.zeros(count), np.zeros((count, 3))

    def begin(self, vertices: npt.NDArray[np.float32]) -> None:
        """Begin with vertices (n, 3) that no sweep has moved, and of which nothing is proven."""
        self.state[2][:] = TOLD
        self._doubt.remember(vertices)

    @property
    def doubted(self) -> npt.NDArray[np.int8]:
        """(l,) more than 0 at vertices that have been looked at."""
        return self._doubt.doubted

    def depth(
        self, vertices: npt.NDArray[np.float32], gaps: FloatArray, unsure: npt.NDArray[np.bool_],
        folds: FloatArray | None,
    ) -> float:  # fmt: skip
        """Metres that any vertex of a lip is in the other at the most, negative where none is; vertices are (n, 3).

        Where the quick look can be trusted they count as clear; for the rest see `LipDoubt`.
        """
        doubted = self._doubt.look(vertices, gaps, unsure, self.state[2], folds)
        trust_others(self._doubt.doubted, TOLD, self.state[2])
        if not doubted:
            return -TOLD
        return -float(prove(vertices, self.rest, self._points, self._surface, self._blocks, self._work, self.state))


def _facing(
    centres: npt.NDArray[np.floating], sides: Numbers, places: npt.NDArray[np.float32], side_of: Numbers
) -> Numbers:
    """(l,) triangle, by centres (t, 3) and sides (t,), that is nearest to each of places (l, 3) on the other side."""
    facing = np.zeros(len(places), np.int32)
    for side in (0, 1):
        mine, other = np.flatnonzero(side_of == side), np.flatnonzero(sides == 1 - side)
        if len(mine) and len(other):
            facing[mine] = other[cKDTree(centres[other]).query(places[mine])[1]]
    return facing
