"""The surface that is seen: carried by the nodes of a mesh, and as fine as the eye needs it."""

from __future__ import annotations

from dataclasses import dataclass

import h5py
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from risorius import storage
from risorius.jaw import FloatArray

Colours = npt.NDArray[np.uint8]
NO_COLOURS: Colours = np.zeros((0, 3), dtype=np.uint8)


@dataclass(frozen=True)
class CarriedSurface:
    """A visible surface that goes with a mesh of n nodes.

    points: (v, 3) at rest, metres; they need not be where the weights put them, a surface may show what the mesh has
    not. triangles: (t, 3), outward. weights: (v, n), displacement = weights @ displacement of the nodes.
    colours: (v, 3) sRGB, or NO_COLOURS.
    """

    points: FloatArray
    triangles: npt.NDArray[np.int64]
    weights: sp.csr_matrix
    colours: Colours

    @classmethod
    def of_nodes(cls, points: FloatArray, skin: npt.NDArray[np.int64]) -> CarriedSurface:
        """Return the nodes of skin triangles (m, 3) themselves, of a mesh with nodes `points` (n, 3)."""
        nodes, triangles = np.unique(skin, return_inverse=True)
        weights = sp.csr_matrix(
            (np.ones(len(nodes)), nodes, np.arange(len(nodes) + 1)), shape=(len(nodes), len(points))
        )
        return cls(points[nodes], triangles.reshape(skin.shape), weights, NO_COLOURS)

    def carry(self, fields: npt.NDArray[np.floating]) -> FloatArray:
        """Displacement (k, v, 3) of the surface for displacements of the nodes (k, n, 3)."""
        result = np.empty((len(fields), *self.points.shape))
        for carried, field in zip(result, fields, strict=True):
            carried[:] = self.weights @ field
        return result

    def write(self, group: h5py.Group) -> None:
        """Store the surface in a group of its own."""
        group["points"], group["triangles"], group["colours"] = self.points, self.triangles, self.colours
        storage.write_sparse(group.create_group("weights"), self.weights)

    @classmethod
    def read(cls, group: h5py.Group) -> CarriedSurface:
        """Load what `write` stored."""
        weights = storage.read_sparse(group["weights"])
        return cls(group["points"][()], group["triangles"][()], weights, group["colours"][()])
