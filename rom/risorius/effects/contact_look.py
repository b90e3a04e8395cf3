"""What the kernels of contact are called with."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from risorius.effects.contact_kernels import deepest, press, put_back, resolve
from risorius.effects.contact_patches import Patches
from risorius.effects.contact_tables import ContactTables
from risorius.effects.lip_proof import LipProof
from risorius.effects.retreat import Retreat
from risorius.jaw import FloatArray

AROUND = 10e-3  # metres at rest between a vertex at a corner of the mouth and a patch that may come near it
Numbers = npt.NDArray[np.int32]


class ContactLook:
    """Looks at all points of the tables. Not thread-safe: it owns what it works with.

    turn (3, 3), origin (3,): of the jaw, as it is when it looks. doubtful: whether the last `resolve` may have missed
    something in the lips.
    """

    def __init__(self, tables: ContactTables, retreat: Retreat, turn: FloatArray, origin: FloatArray) -> None:
        t = tables
        self._teeth = (
            t.points, t.onset, t.away, t.distances, t.starts, t.shapes, t.lows, t.spacings, t.moves, *t.least, turn,
            origin,
        )  # fmt: skip
        self._lips = t.vertices, t.facing, t.places, t.triangles, t.across, t.planes, float(t.orientation[0])
        self._rows = t.row_starts, t.row_controls, t.row_shares
        self._columns = t.column_starts, t.column_vertices, t.column_shares, np.unique(t.column_vertices)
        rows, controls = t.shares, t.shares.shape[1]
        touching = t.onset > -1.0
        kinds = np.unique(touching, axis=0, return_inverse=True)[1].ravel()
        slack = -np.where(touching, t.onset, 0.0).min(axis=1, initial=0.0)
        side_of = _sides(t)
        sides = side_of[t.vertices]
        of_lips = Patches.of(rows[t.vertices], sides)
        self._patches = (
            _tables(Patches.of(rows[t.points], kinds), slack),
            _tables(of_lips, np.zeros(len(t.vertices))),
        )
        self._corners = _corners(t, sides, of_lips)
        self.moved = np.zeros((controls, 3))
        points, lips = len(t.points), len(t.vertices)
        self._state = (
            t.facing.copy(), np.zeros(points, np.int32), np.zeros(lips, np.int32), np.zeros(points),
            np.zeros((points, 3)), np.zeros(lips), np.zeros((lips, 3)), np.zeros((controls, 3)),
            np.zeros(controls), self.moved, np.zeros((rows.shape[0], 3)),
        )  # fmt: skip
        self._proof = LipProof(self._lips, side_of, retreat)
        self.doubtful = False
        self.deepest(self._proof.rest)
        self._at_rest = self._state[5][of_lips.leaders]

    def resolve(self, vertices: npt.NDArray[np.float32], folded: bool) -> float:
        """Move vertices (n, 3) out of what the points are in, in place; `moved` (c, 3) is by how much the controls.

        folded: whether tissue was, before it was mended. Returns metres that any point is left in anything at the most, negative where none is.
        """
        depth, self.doubtful = resolve(
            vertices, self._teeth, self._lips, self._rows, self._columns, *self._patches, self._corners, self._at_rest,
            folded, self._state,
        )  # fmt: skip
        return float(depth)

    def press(self, vertices: npt.NDArray[np.float32]) -> None:
        """Move vertices (n, 3) out of what the last look has found, once."""
        press(vertices, self._teeth, self._lips, self._rows, self._columns, self._state)

    def proven(self, vertices: npt.NDArray[np.float32]) -> float:
        """Metres that any of the points is in anything, as the measure has the lips; teeth as the last look had them."""
        return self._proof.depth(vertices, self._patches[1], self._corners, self._state)

    def put_back(self, vertices: npt.NDArray[np.float32]) -> None:
        """Take back what `resolve` has moved vertices (n, 3) by."""
        put_back(vertices, self._rows, self._columns[3], self.moved)

    def deepest(self, vertices: npt.NDArray[np.float32]) -> float:
        """Metres that any of the points is in anything, negative where none is."""
        return float(deepest(vertices, self._teeth, self._lips, *self._patches, self._corners, self._state))


def _sides(tables: ContactTables) -> Numbers:
    """(n,) for each vertex number one of a lip, its side 0 or 1, -1 where none is known: what faces is opposite."""
    count, corners = len(tables.row_starts) - 1, tables.triangles
    if not len(tables.vertices):
        return np.full(count, -1, np.int32)
    faced = corners[tables.facing, 0]
    same = np.concatenate([corners[:, [0, 1]], corners[:, [0, 2]]])
    pairs = np.concatenate(
        [same, same + count, np.column_stack([tables.vertices, faced + count]),
         np.column_stack([tables.vertices + count, faced])]
    )  # fmt: skip
    linked = sp.coo_matrix((np.ones(len(pairs), bool), pairs.T), shape=(2 * count, 2 * count))
    label = connected_components(linked, directed=False)[1]
    first = label[tables.vertices[0]]
    return np.where(label[:count] == first, 0, np.where(label[count:] == first, 1, -1)).astype(np.int32)


def _corners(tables: ContactTables, sides: npt.NDArray[np.integer], patches: Patches) -> tuple[npt.NDArray[Any], ...]:
    """Patches of the other lip near each of the vertices at a corner of the mouth, and triangles around each vertex."""
    t, leaders = tables, patches.leaders
    corner = np.flatnonzero(np.diff(t.candidate_starts))
    rows = sp.lil_matrix((len(t.vertices), len(leaders)), dtype=bool)
    if len(corner):
        found = cKDTree(t.places[leaders]).query_ball_point(t.places[corner], AROUND)
        for number, others in zip(corner, found, strict=True):
            rows[number, [patch for patch in others if sides[leaders[patch]] != sides[number]]] = True
    near = sp.csr_matrix(rows)
    ends = np.ones(t.triangles.size, bool), t.triangles.ravel(), np.arange(0, t.triangles.size + 1, 3)
    fans = sp.csr_matrix(sp.csr_matrix(ends, shape=(len(t.triangles), len(t.row_starts) - 1)).T)
    return (
        near.indptr.astype(np.int32), near.indices.astype(np.int32), t.vertices[leaders[near.indices]],
        t.vertices[patches.order], fans.indptr.astype(np.int32), fans.indices.astype(np.int32), np.zeros(len(leaders)),
    )  # fmt: skip


def _tables(patches: Patches, slack: FloatArray) -> tuple[npt.NDArray[Any], ...]:
    return patches.leaders, slack, patches.order, patches.starts
