"""What the kernels of contact are called with."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from risorius.adjacency import vertex_fans
from risorius.effects.contact_gaps import CLOSE, deepest, find, find_gaps, smallest
from risorius.effects.contact_groups import LipGroups, lip_sides
from risorius.effects.contact_patches import Patches
from risorius.effects.contact_sweeps import adopt, sweep
from risorius.effects.contact_tables import ContactTables
from risorius.effects.lane_blocks import NOWHERE, blocks_of
from risorius.effects.lip_proof import LipProof
from risorius.effects.retreat import Retreat
from risorius.jaw import FloatArray

Numbers = npt.NDArray[np.int32]


class ContactLook:
    """Looks at all points of the tables. Not thread-safe: it owns what it works with.

    turn (3, 3), origin (3,): of the jaw, as it is when it looks.
    """

    def __init__(
        self, tables: ContactTables, groups: LipGroups, retreat: Retreat, turn: FloatArray, origin: FloatArray
    ) -> None:
        t = tables
        self._teeth = (
            t.points, t.onset, t.away, t.distances, t.starts, t.shapes, t.lows, t.spacings, t.moves, *t.least, turn,
            origin,
        )  # fmt: skip
        side_of = lip_sides(t)
        fans, fan_starts = vertex_fans(t.triangles, len(side_of))
        self._lips = (
            t.vertices, t.facing, t.places, t.triangles, t.across, t.planes, float(t.orientation[0]),
            fan_starts.astype(np.int32), fans.astype(np.int32),
        )  # fmt: skip
        self._rows = t.row_starts, t.row_controls, t.row_shares
        self._columns = t.column_starts, t.column_vertices, t.column_shares
        rows, controls = t.shares, t.shares.shape[1]
        patches = Patches.of(rows[t.vertices], side_of[t.vertices])
        self._patches = patches.order, patches.starts
        self._groups = groups.kernel(t.vertices)
        points, lips = len(t.points), len(t.vertices)
        self._blocks = (
            np.zeros((3, points), np.float32), np.ascontiguousarray(t.onset.T), np.zeros((3, 4), np.float32),
            np.zeros(points, np.int32),
        )  # fmt: skip
        self._state: tuple[npt.NDArray[Any], ...] = (
            t.facing.copy(), np.zeros(points, np.int32), np.zeros(lips, np.int32), np.zeros(points),
            np.zeros((points, 3)), np.zeros(lips), np.zeros((lips, 3)), np.zeros((controls, 3)),
            np.zeros(controls), np.zeros((controls, 3)), np.zeros((rows.shape[0], 3)), np.zeros(lips, bool),
            np.zeros(controls, bool),
        )  # fmt: skip
        self._proof = LipProof(tables, side_of, retreat)
        self._around = _around(t, side_of, self._proof.vertices, self._proof.rest)

    def find(self, vertices: npt.NDArray[np.float32], folded: bool) -> float:
        """Look at vertices (n, 3) that nothing has moved yet; return metres that any point is in anything at the most.

        Negative where none is, as in all that follows. It takes longer where tissue may be folded.
        """
        self._proof.begin(vertices)
        find(
            vertices, self._teeth, self._lips, self._blocks, self._patches, self._groups, self._around,
            CLOSE if folded else 0.0, self._state,
        )  # fmt: skip
        return float(deepest(self._state[3], self._state[5]))

    def unsure_places(self) -> FloatArray:
        """Places (f, 3) at rest of points that have been found in the other lip, but may be beside it."""
        return self._proof.rest[self._lips[0][self._state[11] & (self._state[5] < 0.0)]].astype(np.float64)

    def sweep(self, vertices: npt.NDArray[np.float32]) -> None:
        """Move vertices (n, 3) out of what has been found, in place."""
        sweep(vertices, self._teeth, self._lips, self._rows, self._columns, self._state)

    def make_sure(self, vertices: npt.NDArray[np.float32], folds: FloatArray | None) -> float:
        """Metres that any of the points is in anything: lips as the measure has them, teeth as the last look.

        Lips are looked at where sweeps or folds (f, 3) of tissue leave a doubt, everywhere if nobody knows these.
        """
        depth = self._proof.depth(vertices, self._state[5], self._state[11], folds)
        return max(depth, -float(smallest(self._state[3])))

    def adopt(self) -> None:
        """Take what has been found in lips for clear where that was doubted and is not proven."""
        adopt(self._proof.numbers, self._proof.doubted, self._proof.state, self._state)

    def restart(self) -> None:
        """Forget what was near what, and any number that is none."""
        for state in self._state:
            state[:] = 0
        self._state[0][:] = self._lips[1]

    def gaps(self, vertices: npt.NDArray[np.float32]) -> tuple[FloatArray, FloatArray]:
        """Metres (k,) and (l,) of all points, each looked at; those of lips at most SEARCHED."""
        find_gaps(vertices, self._teeth, self._lips, self._around, self._state)
        return self._state[3].copy(), self._state[5].copy()


def _around(tables: ContactTables, side_of: Numbers, lips: Numbers, rest: npt.NDArray[np.float32]) -> tuple[Any, ...]:
    """Sides (l,) of the points at rest (n, 3), and blocks (b, LANES) of vertices of the lips.

    Of the blocks those of side 0 come first; last are where those of side 1 begin, their places (3, b * LANES), and
    spheres (4, b) about them.
    """
    blocks, split = blocks_of(rest[lips], side_of[lips])
    members = np.where(blocks < 0, -1, lips[blocks]).astype(np.int32)
    return (
        side_of[tables.vertices], members, split,
        np.zeros((3, members.size), np.float32), np.full((4, len(members)), NOWHERE, np.float32),
    )  # fmt: skip
