"""The plane of symmetry of a face, x = 0, where it has one: every snapshot then is two."""

from __future__ import annotations

import logging
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from risorius.jaw import FloatArray
from risorius.snapshot_file import SnapshotSet

REVERSED = frozenset({"jaw_sideways"})
SAME_PLACE = 1e-6  # metres
SAME_MOTION = 5e-3  # of the displacement of an action, root mean square: an asymmetric muscle or tissue changes more
# With contact a fold may come to rest elsewhere on the other side, by a machine's last digits: so many nodes may.
FOLDED, FOLDED_MOTION = 0.05, 2e-2
ACROSS = np.array([-1.0, 1.0, 1.0])

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Mirror:
    """nodes (n,): number of each node's image. partner (p,): parameter of the other side. sign (p,): -1 if it turns."""

    nodes: npt.NDArray[np.int64]
    partner: npt.NDArray[np.int64]
    sign: FloatArray

    def image(self, displacements: FloatArray) -> FloatArray:
        """Displacements (..., n, 3) of the face that pulls the other way."""
        return displacements[..., self.nodes, :] * ACROSS


def mirror_of(snapshots: SnapshotSet, singles: npt.NDArray[np.int64]) -> Mirror | None:
    """Mirror of a face, None if it is not symmetric; singles (p,): snapshot of each parameter alone at 1.

    Nodes have to lie on images of nodes, and actions of one side have to move them as those of the other side do. Where
    only the latter is not so, the log says which action.
    """
    names = snapshots.inputs.parameters
    partner = np.array([names.index(other) if (other := _other_side(name)) in names else -1 for name in names])
    sign = np.array([-1.0 if name in REVERSED else 1.0 for name in names])
    distances, nodes = cKDTree(snapshots.points).query(snapshots.points * ACROSS)
    if (partner < 0).any() or (partner == np.arange(len(names))).all() or distances.max() > SAME_PLACE:
        return None
    mirror = Mirror(nodes, partner, sign)
    for parameter in np.flatnonzero(sign > 0.0):
        here, there = (snapshots.displacements[singles[k]] for k in (parameter, partner[parameter]))
        if not _alike(mirror.image(here), there):
            _log.warning(
                "the mesh is its own mirror image, but %s moves it otherwise than on the other side; snapshots are not "
                "mirrored, and teach half as much",
                names[parameter],
            )
            return None
    return mirror


def _alike(image: FloatArray, there: FloatArray) -> bool:
    """Whether displacements (n, 3) are the same, but for folds."""
    apart = np.sort(np.linalg.norm(image - there, axis=1))
    unfolded = apart[: len(apart) - int(FOLDED * len(apart))]
    size = np.linalg.norm(there)
    return bool(np.linalg.norm(unfolded) <= SAME_MOTION * size and np.linalg.norm(apart) <= FOLDED_MOTION * size)


def _other_side(name: str) -> str:
    sides = {"_L": "_R", "_R": "_L"}
    return name[:-2] + sides[name[-2:]] if name[-2:] in sides else name
