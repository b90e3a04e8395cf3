"""What the kernels of contact are called with, for some of the points that may touch."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from risorius.effects.contact_kernels import (
    SWEEPS,
    deepest,
    deepest_beside,
    deepest_of_all,
    farthest,
    resolve,
)
from risorius.effects.contact_patches import Patches
from risorius.effects.contact_tables import ContactTables
from risorius.jaw import FloatArray

FAR_MOVED = 2.5e-3  # metres: a corner of the mouth that sweeps have moved farther is looked at thoroughly
OF_CORNER = 0.3  # largest share of a vertex there in a control of the corner
Numbers = npt.NDArray[np.integer]
Seeds = tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]


class ContactLook:
    """Looks at `points` and `vertices`, numbers of those of the tables. Not thread-safe: it owns what it works with.

    turn (3, 3), origin (3,): of the jaw, as it is when it looks. allowed: metres that a depth may be missed by in
    `deepest`.
    """

    def __init__(
        self, tables: ContactTables, points: Numbers, vertices: Numbers, turn: FloatArray, origin: FloatArray,
        allowed: float = 0.0,
    ) -> None:  # fmt: skip
        t = tables
        onset, chosen, facing = t.onset[points], t.vertices[vertices], t.facing[vertices]
        self._teeth = (
            t.points[points], onset, t.away[points], t.distances, t.starts, t.shapes, t.lows, t.spacings, t.moves,
            *t.least, turn, origin,
        )  # fmt: skip
        self._lips = (
            chosen, facing, t.places[vertices], t.triangles, t.across, t.planes, float(t.orientation[0]),
        )  # fmt: skip
        self._rows = t.row_starts, t.row_controls, t.row_shares
        self._columns = t.column_starts, t.column_vertices, t.column_shares
        rows, controls = t.shares, t.shares.shape[1]
        touching = onset > -1.0
        kinds = np.unique(touching, axis=0, return_inverse=True)[1].ravel()
        slack = -np.where(touching, onset, 0.0).min(axis=1, initial=0.0) - allowed
        of_lips = Patches.of(rows[chosen], np.zeros(len(chosen), np.int64))
        self._patches = (
            _tables(Patches.of(rows[t.points[points]], kinds), slack),
            _tables(of_lips, np.full(len(chosen), -allowed)),
        )
        beside = sp.csr_matrix(rows.T @ rows)
        movers = np.where(np.diff(t.row_starts) > 0, np.append(t.row_controls, -1)[t.row_starts[:-1]], -1)
        self._opposite = (
            movers[t.triangles[:, 0]].astype(np.int32), beside.indptr.astype(np.int32),
            beside.indices.astype(np.int32), np.zeros(controls),
        )  # fmt: skip
        self._everything = np.arange(max(len(points), len(chosen)), dtype=np.int32)
        self._candidates = *_rows(t.candidate_starts, t.candidates, vertices), np.zeros(len(t.triangles))
        corners = rows[t.vertices[np.diff(t.candidate_starts) > 0]]
        self._corners = np.unique(corners.indices[corners.data > OF_CORNER])
        self.moved = np.zeros((controls, 3))
        self._state = (
            facing.copy(), np.zeros(len(points), np.int32), np.zeros(len(chosen), np.int32), np.zeros(len(points)),
            np.zeros((len(points), 3)), np.zeros(len(chosen)), np.zeros((len(chosen), 3)), np.zeros((controls, 3)),
            np.zeros(controls), self.moved, np.zeros(controls),
        )  # fmt: skip

    def resolve(self, vertices: npt.NDArray[np.float32]) -> bool:
        """Move vertices (n, 3) out of what the points are in, in place; `moved` (c, 3) is by how much the controls.

        Returns whether that took fewer sweeps than there may be, and no control at a corner of the mouth moved far.
        """
        sweeps = resolve(
            vertices, self._teeth, self._lips, self._rows, self._columns, *self._patches, self._opposite, self._state
        )
        return bool(sweeps < SWEEPS and farthest(self.moved, self._corners) < FAR_MOVED)

    def deepest(self, vertices: npt.NDArray[np.float32]) -> float:
        """Metres that any of the points is in anything, negative where none is."""
        return float(deepest(vertices, self._teeth, self._lips, *self._patches, self._state))

    def deepest_of_all(self, vertices: npt.NDArray[np.float32]) -> float:
        """As `deepest`, but each point is looked at, and at corners of the mouth all of the other lip."""
        return float(
            deepest_of_all(vertices, self._teeth, self._lips, self._everything, *self._candidates, self._state)
        )

    def deepest_beside(self, vertices: npt.NDArray[np.float32], seeds: Seeds, seen: ContactLook) -> float:
        """As `deepest`, of points beside those that another look has just `seen`."""
        return float(
            deepest_beside(
                vertices, self._teeth, self._lips, self._state, *seeds, seen._teeth[0], seen._lips[0], seen._state
            )
        )


def _rows(starts: npt.NDArray[np.int32], entries: npt.NDArray[np.int32], rows: Numbers) -> tuple[npt.NDArray[Any], ...]:
    """Starts and entries of some rows."""
    table = [entries[starts[row] : starts[row + 1]] for row in rows]
    return np.cumsum([0, *map(len, table)]).astype(np.int32), np.concatenate([entries[:0], *table])


def _tables(patches: Patches, slack: FloatArray) -> tuple[npt.NDArray[Any], ...]:
    return patches.leaders, slack, patches.order, patches.starts, patches.control_starts, patches.controls
