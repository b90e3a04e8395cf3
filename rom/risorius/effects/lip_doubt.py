"""Which points of the lips the quick look cannot be trusted at."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from risorius.effects.contact_doubt import AT_WORK, doubt
from risorius.effects.contact_patches import Patches, surround
from risorius.effects.contact_tables import ContactTables
from risorius.effects.lane_blocks import NOWHERE
from risorius.jaw import FloatArray
from risorius.vector_lanes import LANES

Numbers = npt.NDArray[np.int32]


class LipDoubt:
    """Doubts points of patches of vertices (l,) of the lips. Not thread-safe: it owns what it works with.

    numbers (k,): of the points of the tables among them. sides (l,): lips that they are on, 0 or 1. rest (n, 3).
    spheres (4, g + LANES): about the patches, at their leaders, as they were when last looked at. doubted (l,): 0 where
    the quick look is trusted.
    """

    def __init__(
        self, tables: ContactTables, vertices: Numbers, numbers: Numbers, sides: Numbers, patches: Patches,
        rest: npt.NDArray[np.float32],
    ) -> None:  # fmt: skip
        count = len(patches.leaders)
        self._vertices, self._rest = vertices, rest
        self._patches = patches.order, patches.starts, int((sides[patches.leaders] == 0).sum()), numbers
        rows = tables.row_starts, tables.row_controls, tables.row_shares
        self._controls = rows, _reached(tables, vertices, patches)
        self.spheres, self._at_rest = np.full((2, 4, count + LANES), NOWHERE, np.float32)
        surround(rest, vertices, patches.order, patches.starts, self._at_rest)
        largest = int(np.diff(patches.starts).max(initial=0))
        self._work = np.zeros(count), np.zeros((3, largest + LANES), np.float32)
        self.doubted = np.zeros(len(vertices), np.int8)

    def look(
        self, vertices: npt.NDArray[np.float32], moved: FloatArray, gaps: FloatArray, proven: FloatArray,
        folds: FloatArray | None,
    ) -> bool:  # fmt: skip
        """Set `doubted`, and the spheres where any point is; return whether any is.

        vertices (n, 3); moved (c, 3): by how much controls have moved them; gaps (k,): of the points of the tables that
        sweeps have left; proven (l,): gaps that were proven before them; folds (f, 3): places at rest where tissue was
        folded, None where nobody knows.
        """
        if folds is None:
            self.doubted[:] = AT_WORK
            surround(vertices, self._vertices, *self._patches[:2], self.spheres)
            return True
        found = doubt(
            vertices, self._rest, moved, gaps, proven, folds, self._vertices, self._patches, self._controls,
            self.spheres, self._at_rest, self._work, self.doubted,
        )  # fmt: skip
        return bool(found)


def _reached(tables: ContactTables, vertices: Numbers, patches: Patches) -> tuple[Numbers, Numbers, FloatArray]:
    """Which patches of vertices (l,) each control moves: where its own begin (c + 1,), numbers, largest shares."""
    patch = np.empty(len(vertices), np.int32)
    patch[patches.order] = np.repeat(np.arange(len(patches.leaders)), np.diff(patches.starts))
    shares = tables.shares[vertices].tocoo()
    pairs, place = np.unique(np.column_stack([shares.col, patch[shares.row]]), axis=0, return_inverse=True)
    most = np.zeros(len(pairs))
    np.maximum.at(most, place.ravel(), shares.data)
    starts = np.searchsorted(pairs[:, 0], np.arange(shares.shape[1] + 1))
    return starts.astype(np.int32), pairs[:, 1].astype(np.int32), most
