"""Fibres as an elastic test deformation of the muscle, (7.7): pushed in at the insertion, drawn out at the origin.

As printed, (7.7) holds the whole capsule, tau = 0. Its solution then is no bundle of parallel fibres: next to the ends
the flow turns from the flat profile of the data to one that vanishes on the capsule, and decays between them. On the
nested cylinders (Figure 7.7) tau leaves the axis by up to 14 degrees at nu = 0 to 0.3 and by 9 to 10 at nu = 0.45 to
0.499, at 38 to 89 % of all points by more than one, so no treatment of the rim alone can mend it. A capsule that no
fibre crosses, but along which tissue slides, gives what the seed shows: axial fibres, exactly. It is the default; the
condition as printed remains by name.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, TypeAlias, get_args

import h5py
import numpy as np
import scipy.sparse as sp

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.discretisation import Discretisation, IntArray
from risorius_offline.muscles.areas import Area
from risorius_offline.muscles.constrained_minimum import assembled, constrained_minimum
from risorius_offline.muscles.fibres import FibreField, InsertionEnd
from risorius_offline.muscles.laplace_fibres import LaplaceFibres
from risorius_offline.muscles.region import Region, normalised

Capsule: TypeAlias = Literal["sliding", "fixed"]


@dataclass(frozen=True)
class DeformationFibres:
    """The direction of tau in the cells of the region, (7.7):

        (1 - 2 nu) lap tau + grad div tau = 0,    tau = -n on the insertion, n on the origin

    and on the capsule tau . n = 0 without shear traction (`sliding`), or tau = 0 (`fixed`). The ends' values hold on
    their rims too, where they meet the capsule.
    poisson: nu in [0, 0.5), a slight control on the directions.
    """

    region: Region
    poisson: float = 0.3
    capsule: Capsule = "sliding"
    kind: ClassVar[str] = "deformation"

    def __post_init__(self) -> None:
        if not 0.0 <= self.poisson < 0.5:
            raise InputError(f"test deformation: Poisson's ratio {self.poisson:g}; give a number in [0, 0.5)")
        if self.capsule not in get_args(Capsule):
            raise InputError(f"test deformation: capsule {self.capsule!r}; write one of {', '.join(get_args(Capsule))}")

    def field(self, discretisation: Discretisation) -> FibreField:
        """All points of the region where tau has a length; raises InputError for a region without proper areas."""
        tau = self.tangents(discretisation)
        blocks = self.region.blocks(discretisation)
        return normalised(blocks, [np.einsum("qa,eai->eqi", b.shapes, tau[b.connectivity]) for b in blocks])

    def tangents(self, discretisation: Discretisation) -> FloatArray:
        """(n, 3) nodal tau before it is normalised, zero outside the region."""
        areas, blocks = self.region.areas(discretisation), self.region.blocks(discretisation)
        dofs = [(3 * b.connectivity[:, :, None] + np.arange(3)).reshape(len(b.connectivity), -1) for b in blocks]
        stiffness = assembled(
            [_stiffness(b.gradients, b.weights, self.poisson) for b in blocks], dofs, discretisation.dof_count
        )
        tau = np.zeros_like(discretisation.points)
        tau[areas.insertion.nodes] = -areas.insertion.normals
        tau[areas.origin.nodes] = areas.origin.normals
        ends = np.union1d(areas.origin.nodes, areas.insertion.nodes)
        inside = np.unique(np.concatenate([b.connectivity.ravel() for b in blocks]))
        interior = np.setdiff1d(inside, np.union1d(ends, areas.capsule.nodes))
        free = [_unit_variations(interior, len(tau))]
        if self.capsule == "sliding":
            free.append(_tangential_variations(areas.capsule, ends, len(tau)))
        return constrained_minimum(stiffness, tau.ravel(), sp.hstack(free, format="csr")).reshape(-1, 3)

    def length(self, discretisation: Discretisation) -> float:
        """Mean length of the harmonic fibres of the region, metres: both join the same ends."""
        return LaplaceFibres(self.region).length(discretisation)

    def insertion_end(self, discretisation: Discretisation) -> InsertionEnd:
        """Centroid and mean normal of the insertion."""
        return self.region.insertion_end(discretisation)

    def write(self, group: h5py.Group) -> None:
        """Store region, Poisson's ratio and the condition on the capsule."""
        self.region.write(group)
        group.attrs.update(poisson=self.poisson, capsule=self.capsule)

    @classmethod
    def read(cls, group: h5py.Group) -> DeformationFibres:
        """Load what `write` stored."""
        return cls(Region.read(group), float(group.attrs["poisson"]), group.attrs["capsule"])


def _stiffness(gradients: FloatArray, weights: FloatArray, poisson: float) -> FloatArray:
    """(e, 3 a, 3 a) of linear elasticity with a shear modulus of one: (7.7) is its equation, divided by 1 - 2 nu."""
    lame = 2.0 * poisson / (1.0 - 2.0 * poisson)
    outer = np.einsum("eq,eqai,eqbj->eaibj", weights, gradients, gradients, optimize=True)
    laplacian = np.einsum("eakbk->eab", outer)
    full = lame * outer + outer.swapaxes(2, 4) + np.einsum("eab,ij->eaibj", laplacian, np.eye(3))
    return full.reshape(len(full), 3 * gradients.shape[2], -1)


def _unit_variations(nodes: IntArray, node_count: int) -> sp.csr_matrix:
    """(3 n, 3 k) all components of the nodes (k,)."""
    rows = (3 * nodes[:, None] + np.arange(3)).ravel()
    return sp.csr_matrix((np.ones(len(rows)), (rows, np.arange(len(rows)))), shape=(3 * node_count, len(rows)))


def _tangential_variations(capsule: Area, ends: IntArray, node_count: int) -> sp.csr_matrix:
    """(3 n, 2 k) two directions across the normal of each of the k nodes of the capsule that are on neither end."""
    apart = ~np.isin(capsule.nodes, ends)
    tangents = np.linalg.svd(capsule.normals[apart, None, :])[2][:, 1:]
    count = len(tangents)
    rows = np.broadcast_to(3 * capsule.nodes[apart, None, None] + np.arange(3), tangents.shape)
    columns = np.broadcast_to(np.arange(2 * count).reshape(count, 2, 1), tangents.shape)
    return sp.csr_matrix((tangents.ravel(), (rows.ravel(), columns.ravel())), shape=(3 * node_count, 2 * count))
