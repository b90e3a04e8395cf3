"""Which points of the lips the quick look cannot be trusted at."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from risorius.effects.contact_doubt import AT_WORK, doubt
from risorius.effects.contact_patches import Patches, surround
from risorius.effects.lane_blocks import NOWHERE
from risorius.jaw import FloatArray
from risorius.vector_lanes import LANES

Numbers = npt.NDArray[np.int32]
Flags = npt.NDArray[np.bool_]


class LipDoubt:
    """Doubts points of patches of vertices (l,) of the lips. Not thread-safe: it owns what it works with.

    numbers (k,): of the points of the tables among them. sides (l,): lips that they are on, 0 or 1. rest (n, 3).
    spheres (4, g + LANES): about the patches, at their leaders, as they were when last looked at. doubted (l,): 0 where
    the quick look is trusted.
    """

    def __init__(
        self, vertices: Numbers, numbers: Numbers, sides: Numbers, patches: Patches, rest: npt.NDArray[np.float32]
    ) -> None:
        count = len(patches.leaders)
        self._vertices, self._rest = vertices, rest
        self._patches = patches.order, patches.starts, int((sides[patches.leaders] == 0).sum()), numbers
        self._before = rest[vertices]
        self.spheres, self._at_rest = np.full((2, 4, count + LANES), NOWHERE, np.float32)
        surround(rest, vertices, patches.order, patches.starts, self._at_rest)
        largest = int(np.diff(patches.starts).max(initial=0))
        self._work = np.zeros(count, np.float32), np.zeros((3, largest + LANES), np.float32)
        self.doubted = np.zeros(len(vertices), np.int8)

    def remember(self, vertices: npt.NDArray[np.float32]) -> None:
        """Keep where vertices (n, 3) of the lips are before sweeps."""
        np.take(vertices, self._vertices, axis=0, out=self._before, mode="clip")

    def look(
        self, vertices: npt.NDArray[np.float32], gaps: FloatArray, unsure: Flags, proven: FloatArray,
        folds: FloatArray | None,
    ) -> bool:  # fmt: skip
        """Set `doubted`, and the spheres where any point is; return whether any is.

        vertices (n, 3); gaps (k,): of the points of the tables that sweeps have left, of which some are unsure (k,);
        proven (l,): gaps that were proven before them; folds (f, 3): places at rest where tissue was folded, None
        where nobody knows.
        """
        if folds is None:
            self.doubted[:] = AT_WORK
            surround(vertices, self._vertices, *self._patches[:2], self.spheres)
            return True
        found = doubt(
            vertices, self._before, self._rest, gaps, unsure, proven, folds, self._vertices, self._patches,
            self.spheres, self._at_rest, self._work, self.doubted,
        )  # fmt: skip
        return bool(found)
