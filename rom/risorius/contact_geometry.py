"""What skin can touch: teeth, as distances on regular grids, and lips where they face each other at rest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import h5py
import numpy as np
import numpy.typing as npt
from scipy.ndimage import map_coordinates

from risorius import storage
from risorius.companion import JAW, SKULL
from risorius.errors import InputError
from risorius.jaw import FloatArray


@dataclass(frozen=True)
class Obstacle:
    """A rigid thing: its signed distance (nx, ny, nz), metres, negative inside, at origin + spacing (i, j, k) at rest.

    Linear between these points; beyond them it is far. moves_with: SKULL, which stays where it is, or JAW. Raises
    InputError for anything else.
    """

    origin: FloatArray
    spacing: float
    distances: npt.NDArray[np.float32]
    moves_with: str = SKULL

    def __post_init__(self) -> None:
        if self.moves_with not in (SKULL, JAW):
            raise InputError(f"obstacle: moves_with {self.moves_with!r}; give {SKULL!r} or {JAW!r}")

    def distance(self, points: npt.NDArray[np.floating]) -> FloatArray:
        """Distances (k,) of points (k, 3), as seen from the obstacle at rest; the largest there is beyond the grid."""
        places = (np.asarray(points, dtype=np.float64) - self.origin) / self.spacing
        result: FloatArray = map_coordinates(
            self.distances.astype(np.float64), places.T, order=1, mode="constant", cval=float(self.distances.max())
        )
        return result

    def slope(self, points: npt.NDArray[np.floating]) -> FloatArray:
        """Derivatives (k, 3) of the distance, as differences over a step of the grid."""
        steps = 0.5 * self.spacing * np.eye(3)
        sides = [self.distance(points + step) - self.distance(points - step) for step in steps]
        return np.stack(sides, axis=1) / self.spacing

    def write(self, group: h5py.Group) -> None:
        """Store the obstacle in a group of its own."""
        group["origin"] = self.origin
        group.create_dataset("distances", data=self.distances, chunks=True, compression="gzip", shuffle=True)
        group.attrs["spacing"], group.attrs["moves_with"] = self.spacing, self.moves_with

    @classmethod
    def read(cls, group: h5py.Group) -> Obstacle:
        """Load what `write` stored."""
        return cls(group["origin"][()], distances=group["distances"][()], **storage.plain_attributes(group))


@dataclass(frozen=True)
class ContactGeometry:
    """Obstacles by name, and seam (k, 2): points of the visible surface, each with a triangle that it faces at rest."""

    obstacles: Mapping[str, Obstacle]
    seam: npt.NDArray[np.int64]

    def write(self, group: h5py.Group) -> None:
        """Store all fields in an HDF5 group."""
        group["seam"] = self.seam
        for name, obstacle in self.obstacles.items():
            obstacle.write(group.create_group(f"obstacles/{name}"))

    @classmethod
    def read(cls, group: h5py.Group) -> ContactGeometry:
        """Load what `write` stored."""
        obstacles = {name: Obstacle.read(item) for name, item in group.get("obstacles", {}).items()}
        return cls(obstacles, group["seam"][()])
