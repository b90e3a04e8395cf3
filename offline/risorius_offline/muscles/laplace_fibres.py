"""Fibres as the gradient of a harmonic function, (7.5) and (7.6): curl-free, they form no knots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import h5py
import numpy as np
import scipy.sparse as sp

from risorius_offline.discretisation import Discretisation
from risorius_offline.muscles.constrained_minimum import assembled, constrained_minimum
from risorius_offline.muscles.fibres import FibreField, InsertionEnd
from risorius_offline.muscles.region import Region, normalised


@dataclass(frozen=True)
class LaplaceFibres:
    """The direction of grad psi in the cells of the region, where psi is harmonic, 0 on the insertion, 1 on the
    origin, and no fibre leaves through the capsule: d psi / dn = 0.
    """

    region: Region
    kind: ClassVar[str] = "laplace"

    def field(self, discretisation: Discretisation) -> FibreField:
        """All points of the region where psi has a gradient; raises InputError for a region without proper areas."""
        areas, blocks = self.region.areas(discretisation), self.region.blocks(discretisation)
        count = len(discretisation.points)
        stiffness = assembled(
            [np.einsum("eq,eqai,eqbi->eab", b.weights, b.gradients, b.gradients, optimize=True) for b in blocks],
            [b.connectivity for b in blocks],
            count,
        )
        psi = np.zeros(count)
        psi[areas.origin.nodes] = 1.0
        inside = np.unique(np.concatenate([b.connectivity.ravel() for b in blocks]))
        free = np.setdiff1d(inside, np.union1d(areas.origin.nodes, areas.insertion.nodes))
        variations = sp.csr_matrix((np.ones(len(free)), (free, np.arange(len(free)))), shape=(count, len(free)))
        psi = constrained_minimum(stiffness, psi, variations)
        gradients = [np.einsum("eqai,ea->eqi", b.gradients, psi[b.connectivity]) for b in blocks]
        return normalised(blocks, gradients)

    def insertion_end(self, discretisation: Discretisation) -> InsertionEnd:
        """Centroid and mean normal of the insertion."""
        return self.region.insertion_end(discretisation)

    def write(self, group: h5py.Group) -> None:
        """Store the region."""
        self.region.write(group)

    @classmethod
    def read(cls, group: h5py.Group) -> LaplaceFibres:
        """Load what `write` stored."""
        return cls(Region.read(group))
