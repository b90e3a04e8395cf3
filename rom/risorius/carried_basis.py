"""The basis of the visible vertices, kept where it comes from: at the points that carry them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import h5py
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from risorius import storage
from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius.part import Part
from risorius.surface import CarriedSurface
from risorius.whole_steps import rounded_fields


@dataclass(frozen=True)
class CarriedBasis:
    """Fields of n vertices that are weights (n, m) @ fields of m carrying points.

    fields: (r, m, 3) float32, metres per unit coordinate, rounded to 16 bits so that reading them takes half the time.
    Raises InputError where fields and weights do not fit.
    """

    fields: npt.NDArray[np.float32]
    weights: sp.csr_matrix

    def __post_init__(self) -> None:
        if self.fields.shape[1:] != (self.weights.shape[1], 3):
            raise InputError(
                f"basis: fields {self.fields.shape} do not go with weights {self.weights.shape}; "
                f"give fields (r, {self.weights.shape[1]}, 3)"
            )

    @classmethod
    def of_surface(cls, surface: CarriedSurface, fields: FloatArray) -> CarriedBasis:
        """Basis of a surface from fields (r, nodes, 3) on all nodes of its mesh; only those that carry it are kept."""
        carriers = np.unique(surface.weights.indices)
        return cls(rounded_fields(fields[:, carriers].astype(np.float32)), surface.weights[:, carriers].tocsr())

    @classmethod
    def of_vertices(cls, basis: npt.NDArray[np.float32]) -> CarriedBasis:
        """Basis (r, n, 3) whose vertices carry themselves."""
        return cls(rounded_fields(basis), sp.identity(basis.shape[1], format="csr"))

    def __len__(self) -> int:
        return len(self.fields)

    def leading(self, count: int) -> CarriedBasis:
        """Basis of the first fields only."""
        return CarriedBasis(self.fields[:count], self.weights)

    def within(self, part: Part) -> CarriedBasis:
        """Basis of the coordinates, carriers and vertices of a part."""
        fields = self.fields[np.ix_(part.coordinates, part.carriers)]
        return CarriedBasis(fields, self.weights[part.vertices][:, part.carriers].tocsr())

    def followed_by(self, fields: Sequence[npt.NDArray[np.float32]]) -> CarriedBasis:
        """Basis with further fields (k, m, 3) behind its own."""
        return CarriedBasis(np.concatenate([self.fields, *fields]), self.weights) if fields else self

    def in_axes(self, order: tuple[int, int, int]) -> CarriedBasis:
        """Basis with the components of its fields in another order."""
        return CarriedBasis(np.ascontiguousarray(self.fields[:, :, list(order)]), self.weights)

    def at_vertices(self) -> npt.NDArray[np.float32]:
        """(r, n, 3): fields of the vertices themselves."""
        result = np.empty((len(self), self.weights.shape[0], 3), np.float32)
        for carried, field in zip(result, self.fields, strict=True):
            carried[:] = self.weights @ field
        return result

    def write(self, group: h5py.Group) -> None:
        """Store fields and weights."""
        group.create_dataset("fields", data=self.fields, chunks=True, compression="gzip", shuffle=True)
        storage.write_sparse(group.create_group("weights"), self.weights)

    @classmethod
    def read(cls, group: h5py.Group) -> CarriedBasis:
        """Load what `write` stored."""
        return cls(rounded_fields(group["fields"][()]), storage.read_sparse(group["weights"]))
