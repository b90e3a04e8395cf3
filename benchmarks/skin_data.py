"""Bases and coordinates that the benchmarks of the skin's reconstruction share.

Modes and coordinates are those of a snapshot file of the built-in head. For another size of the head, the modes are
interpolated to the nodes that carry its skin: as many bytes, and as smooth as the coarser mesh has them.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.interpolate import RBFInterpolator

from risorius.carried_basis import CarriedBasis
from risorius.jaw import FloatArray
from risorius.snapshot_file import SnapshotSet
from risorius.surface import CarriedSurface
from risorius.training import project
from risorius_offline.head import built_in_head

NEIGHBOURS = 24


@dataclass(frozen=True)
class Modes:
    """fields (r, nodes, 3) on the nodes (nodes, 3) of a mesh, lifts first; coordinates (s, r) of its snapshots."""

    points: FloatArray
    surface: CarriedSurface
    fields: FloatArray
    coordinates: FloatArray

    @classmethod
    def of_snapshots(cls, path: Path, rank: int) -> Modes:
        """Lift fields and at most `rank` POD modes of a snapshot file."""
        snapshots = SnapshotSet.load(path)
        modal = project(snapshots, rank)
        weights = snapshots.parameters[:, len(snapshots.muscles) :]
        lifts = np.stack([snapshots.poses.lift_coordinates(row) for row in weights])
        return cls(
            snapshots.points,
            snapshots.surface,
            np.concatenate([snapshots.lift_fields, modal.modes]),
            np.hstack([lifts, modal.coordinates]),
        )

    def on_head(self, size: str) -> Modes:
        """The same modes on the built-in head of another size."""
        anatomy = built_in_head(size)
        surface, ours = anatomy.visible_surface, np.unique(self.surface.weights.indices)
        theirs = np.unique(surface.weights.indices)
        _, single = np.unique(self.points[ours].round(6), axis=0, return_index=True)
        ours = ours[single]
        flat = self.fields[:, ours].transpose(1, 0, 2).reshape(len(ours), -1)
        found = RBFInterpolator(self.points[ours], flat, neighbors=NEIGHBOURS)(anatomy.points[theirs])
        fields = np.zeros((len(self.fields), *anatomy.points.shape))
        fields[:, theirs] = found.reshape(len(theirs), -1, 3).transpose(1, 0, 2)
        return Modes(anatomy.points, surface, fields, self.coordinates)

    def basis(self, count: int) -> CarriedBasis:
        """Basis of the first `count` fields."""
        return CarriedBasis.of_surface(self.surface, self.fields[:count])

    @property
    def rest(self) -> npt.NDArray[np.float32]:
        """(v, 3) visible vertices at rest."""
        return self.surface.points.astype(np.float32)
