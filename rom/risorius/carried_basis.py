"""The basis of the visible vertices, kept where it comes from: at the points that carry them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

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

ROUNDED_OFF = 5e-6  # m, root mean square over carrying points of what coarse fields leave out


@dataclass(frozen=True)
class CarriedBasis:
    """Fields of n vertices that are weights (n, m) @ fields of m carrying points.

    fields: (r, m, 3) float32, metres per unit coordinate, rounded to 16 bits so that reading them takes half the time.
    coarse: (r,) those rounded to 8 bits; none unless given.
    Raises InputError where fields and weights do not fit.
    """

    fields: npt.NDArray[np.float32]
    weights: sp.csr_matrix
    coarse: npt.NDArray[np.bool_] | None = None

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

    def rounded_off(self, sizes: FloatArray) -> CarriedBasis:
        """Basis whose last fields are coarse: as many as leave out ROUNDED_OFF at coordinates of sizes (r,)."""
        eight = rounded_fields(self.fields, np.int8)
        squares = 3.0 * np.square(sizes) * np.square(eight - self.fields).mean(axis=(1, 2))
        coarse = np.cumsum(squares[::-1])[::-1] <= ROUNDED_OFF**2
        return replace(self, fields=np.where(coarse[:, None, None], eight, self.fields), coarse=coarse)

    def __len__(self) -> int:
        return len(self.fields)

    def leading(self, count: int) -> CarriedBasis:
        """Basis of the first fields only."""
        return replace(self, fields=self.fields[:count], coarse=self._coarse_ones(np.arange(count)))

    def within(self, part: Part) -> CarriedBasis:
        """Basis of the coordinates, carriers and vertices of a part."""
        fields = self.fields[np.ix_(part.coordinates, part.carriers)]
        weights = self.weights[part.vertices][:, part.carriers].tocsr()
        return CarriedBasis(fields, weights, self._coarse_ones(part.coordinates))

    def followed_by(self, fields: Sequence[npt.NDArray[np.float32]]) -> CarriedBasis:
        """Basis with further fields (k, m, 3) behind its own."""
        if not fields:
            return self
        coarse = None if self.coarse is None else np.append(self.coarse, np.zeros(sum(map(len, fields)), bool))
        return CarriedBasis(np.concatenate([self.fields, *fields]), self.weights, coarse)

    def in_axes(self, order: tuple[int, int, int]) -> CarriedBasis:
        """Basis with the components of its fields in another order."""
        return replace(self, fields=np.ascontiguousarray(self.fields[:, :, list(order)]))

    @property
    def carried_by_themselves(self) -> bool:
        """Whether vertices are the points that carry them, one each: fields there are rounded as at the points."""
        return bool((np.diff(self.weights.indptr) == 1).all() and (self.weights.data == 1.0).all())

    def at_vertices(self) -> npt.NDArray[np.float32]:
        """(r, n, 3): fields of the vertices themselves."""
        result = np.empty((len(self), self.weights.shape[0], 3), np.float32)
        for carried, field in zip(result, self.fields, strict=True):
            carried[:] = self.weights @ field
        return result

    def _coarse_ones(self, which: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_] | None:
        return None if self.coarse is None else self.coarse[which]

    def write(self, group: h5py.Group) -> None:
        """Store fields, weights, and which fields are coarse."""
        group.create_dataset("fields", data=self.fields, chunks=True, compression="gzip", shuffle=True)
        storage.write_sparse(group.create_group("weights"), self.weights)
        if self.coarse is not None:
            group["coarse"] = self.coarse

    @classmethod
    def read(cls, group: h5py.Group) -> CarriedBasis:
        """Load what `write` stored."""
        coarse = group["coarse"][()] if "coarse" in group else None
        return cls(rounded_fields(group["fields"][()]), storage.read_sparse(group["weights"]), coarse)
