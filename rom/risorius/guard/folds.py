"""Folded tissue in reduced coordinates: found at the watched points, and unfolded there by the least change."""

from __future__ import annotations

import numpy as np

from risorius.guard.kernels import push, smallest_determinant
from risorius.guard.watch import Watch
from risorius.jaw import FloatArray
from risorius.packed_fields import PackedFields

FOLDED = 2e-3  # J, positive whatever rounding of gradients does: up to 9e-4 in 500 random frames of the built-in head
UNFOLDED = 0.05  # J that a folded point is pushed to
LONGEST_PUSH = 1.0  # modal coordinates: a millimetre, root mean square
MOST_PUSHES = 32


class Folds:
    """Looks at the watched points of a face whose first `lifts` coordinates its poses prescribe. Not thread-safe."""

    def __init__(self, watch: Watch, lifts: int) -> None:
        self._lifts, self._places = lifts, watch.places
        self._fields = PackedFields(watch.gradients.reshape(len(watch.gradients), -1, 3))
        self._slopes = np.ascontiguousarray(watch.gradients[lifts:].transpose(1, 2, 0))
        self._jacobians = np.empty(len(watch), np.float32)
        self._direction = np.empty(self._slopes.shape[2])
        rest = np.zeros(len(watch.gradients))
        self.smallest(rest)
        self._push(rest)  # what few frames need is compiled here, so that none of them waits for it

    def smallest(self, coordinates: FloatArray) -> float:
        """Smallest J at the watched points for coordinates (r,)."""
        self._change = self._fields.combined(coordinates)
        return float(smallest_determinant(self._change, self._jacobians))

    def places(self) -> FloatArray | None:
        """Places (f, 3) at rest of the points that were folded when last looked at; None where nobody knows them."""
        return None if self._places is None else self._places[self._jacobians <= FOLDED]

    def unfold(self, coordinates: FloatArray) -> bool:
        """Change the modal coordinates until no watched point is folded; False where that is not found.

        The worst point is pushed along the gradient of its J, which is the shortest way, and then the worst again.
        """
        for _ in range(MOST_PUSHES):
            if self.smallest(coordinates) > FOLDED:
                return True
            self._push(coordinates)
        return self.smallest(coordinates) > FOLDED

    def _push(self, coordinates: FloatArray) -> None:
        modal = coordinates[self._lifts :]
        push(self._change, self._jacobians, self._slopes, UNFOLDED, LONGEST_PUSH, self._direction, modal)
