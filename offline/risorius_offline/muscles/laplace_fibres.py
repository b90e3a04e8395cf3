"""Fibres as the gradient of a harmonic function, (7.5) and (7.6): curl-free, they form no knots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import h5py
import numpy as np
import scipy.sparse as sp

from risorius.jaw import FloatArray
from risorius_offline.discretisation import Discretisation
from risorius_offline.muscles.constrained_minimum import assembled, constrained_minimum
from risorius_offline.muscles.fibres import FibreField, InsertionEnd
from risorius_offline.muscles.region import Region, RegionBlock, normalised


@dataclass(frozen=True)
class LaplaceFibres:
    """The direction of grad psi in the cells of the region, where psi is harmonic, 0 on the insertion, 1 on the
    origin, and no fibre leaves through the capsule: d psi / dn = 0.
    """

    region: Region
    kind: ClassVar[str] = "laplace"

    def field(self, discretisation: Discretisation) -> FibreField:
        """All points of the region where psi has a gradient; raises InputError for a region without proper areas."""
        return normalised(*self._gradients(discretisation))

    def length(self, discretisation: Discretisation) -> float:
        """Mean length of the fibres, metres, weighted by the flux of grad psi in them.

        Flux is the same all along a fibre, so that its integral over the fibres' lengths is that of |grad psi| over the
        region, and the flux of all fibres is the integral of |grad psi|^2.
        """
        blocks, gradients = self._gradients(discretisation)
        norms = [np.linalg.norm(g, axis=2) for g in gradients]
        along, flux = (
            sum(float((block.weights * norm**power).sum()) for block, norm in zip(blocks, norms, strict=True))
            for power in (1, 2)
        )
        return along / flux

    def _gradients(self, discretisation: Discretisation) -> tuple[list[RegionBlock], list[FloatArray]]:
        """Blocks of the region and grad psi (e, q, 3) at their points."""
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
        return blocks, [np.einsum("eqai,ea->eqi", b.gradients, psi[b.connectivity]) for b in blocks]

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
