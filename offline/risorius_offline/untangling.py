"""From a displacement that turns cells inside out to one beside it that does not, for a solve to start from.

The deformation gradients of squeezed cells, and of those around, are moved to the nearest with admissible principal
stretches, and the displacement is fitted to them by least squares, in turns: as-rigid-as-possible deformation (Sorkine
and Alexa 2007) with limited strain (Bouaziz et al. 2014). Everything else stays where it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from risorius.jaw import FloatArray
from risorius_offline.bernstein import bernstein_form
from risorius_offline.discretisation import Discretisation, IntArray, IntegratedBlock

# Principal stretches that are let be.
LEAST_STRETCH, LARGEST_STRETCH = 0.4, 2.5
# Least ratio of Bernstein coefficients, deformed over rest, of a cell that is let be, and of one that is mended.
SQUEEZED, MENDED = 0.02, 0.05
# Cells around a squeezed one that move with it, at first, and how often there is one more.
RINGS, WIDER = 2, 4
TURNS, TURNS_BETWEEN_LOOKS = 15, 3

Flags = npt.NDArray[np.bool_]


class Untangling:
    """Mends displacements of a mesh whose `prescribed` (n,) nodes stay."""

    def __init__(self, discretisation: Discretisation, prescribed: Flags) -> None:
        self._points, self._free = discretisation.points, ~prescribed
        self._blocks = tuple(_Block.of(block, self._points) for block in discretisation.volumes)

    def untangled(self, u: FloatArray, kept: Flags | None = None) -> FloatArray:
        """Displacement beside u (n, 3), the same at `kept` (n,) nodes; cells may be left that could not be mended."""
        free = self._free if kept is None else self._free & ~kept
        for wider in range(WIDER):
            squeezed = [block.least_ratios(self._points, u) < SQUEEZED for block in self._blocks]
            if not any(flags.any() for flags in squeezed):
                break
            u = self._mended(u, self._inside(squeezed, RINGS + wider) & free)
        return u

    def _inside(self, cells: list[Flags], rings: int) -> Flags:
        """Nodes (n,) of cells and of the rings around them that no other cell has."""
        for _ in range(rings):
            nodes = self._nodes_of(cells)
            cells = [block.having(nodes) for block in self._blocks]
        return self._nodes_of(cells) & ~self._nodes_of([~flags for flags in cells])

    def _nodes_of(self, cells: list[Flags]) -> Flags:
        nodes = np.zeros(len(self._points), bool)
        for block, flags in zip(self._blocks, cells, strict=True):
            nodes[block.connectivity[flags]] = True
        return nodes

    def _mended(self, u: FloatArray, moving: Flags) -> FloatArray:
        """Return u (n, 3) with the moving nodes (n,) where the cells around them are not squeezed, if that can be."""
        patches = [block.at(block.having(moving)) for block in self._blocks]
        numbers = np.flatnonzero(moving)
        matrix = sum((patch.normal_matrix(len(u)) for patch in patches), sp.csr_matrix((len(u), len(u))))[numbers]
        factors, u = splu(matrix[:, numbers].tocsc()), u.copy()
        for turn in range(1, TURNS + 1):
            loads = np.sum([patch.loads(u) for patch in patches], axis=0)
            u[numbers] += factors.solve(loads[numbers])
            looked_at = turn % TURNS_BETWEEN_LOOKS == 0
            if looked_at and all((patch.least_ratios(self._points, u) > MENDED).all() for patch in patches):
                break
        return u


@dataclass(frozen=True)
class _Block:
    """Cells (e, a) of one type with gradients (e, q, a, 3) and weights (e, q) at their points.

    rest: (e, k) Bernstein coefficients.
    """

    cell_type: str
    connectivity: IntArray
    gradients: FloatArray
    weights: FloatArray
    rest: FloatArray

    @classmethod
    def of(cls, block: IntegratedBlock, points: FloatArray) -> _Block:
        kind, connectivity = block.cells.cell_type, block.cells.connectivity
        form = bernstein_form(kind)
        derivatives = np.einsum("eai,kaj->ekij", points[connectivity], form.gradients, optimize=True)
        volumes = np.linalg.det(derivatives)
        inverse = np.linalg.inv(np.where(volumes[..., None, None] > 0.0, derivatives, np.eye(3)))
        gradients = np.einsum("kaj,ekji->ekai", form.gradients, inverse, optimize=True)
        return cls(kind, connectivity, gradients, np.maximum(volumes, 0.0), volumes @ form.form.T)

    def at(self, cells: Flags) -> _Block:
        return _Block(
            self.cell_type, self.connectivity[cells], self.gradients[cells], self.weights[cells], self.rest[cells]
        )

    def having(self, nodes: Flags) -> Flags:
        """Cells (e,) with any of the flagged nodes (n,)."""
        return np.asarray(nodes[self.connectivity].any(axis=1))

    def least_ratios(self, points: FloatArray, u: FloatArray) -> FloatArray:
        """(e,): J is no less where the coefficients at rest are positive; the others are left out."""
        coefficients = bernstein_form(self.cell_type).coefficients((points + u)[self.connectivity])
        positive = self.rest > 0.0
        ratios = np.where(positive, coefficients / np.where(positive, self.rest, 1.0), np.inf)
        return np.asarray(ratios.min(axis=1))

    def normal_matrix(self, nodes: int) -> sp.csr_matrix:
        """(nodes, nodes) of the least squares, for each component."""
        entries = np.einsum("eqai,eqbi,eq->eab", self.gradients, self.gradients, self.weights, optimize=True)
        rows = np.broadcast_to(self.connectivity[:, :, None], entries.shape)
        columns = np.broadcast_to(self.connectivity[:, None, :], entries.shape)
        return sp.csr_matrix((entries.ravel(), (rows.ravel(), columns.ravel())), shape=(nodes, nodes))

    def loads(self, u: FloatArray) -> FloatArray:
        """(n, 3): what is on the right-hand side for the change of u that brings it to admissible gradients."""
        moved = np.einsum("eai,eqaj->eqij", u[self.connectivity], self.gradients, optimize=True) + np.eye(3)
        wanted = _admissible(moved) - moved
        result = np.zeros_like(u)
        shares = np.einsum("eqij,eqaj,eq->eai", wanted, self.gradients, self.weights, optimize=True)
        np.add.at(result, self.connectivity, shares)
        return result


def _admissible(gradients: FloatArray) -> FloatArray:
    """The nearest to deformation gradients (..., 3, 3) whose principal stretches are within limits."""
    result = gradients.copy()
    beyond = ~_within_limits(gradients)
    left, stretches, right = np.linalg.svd(gradients[beyond])
    left[..., 2] *= np.linalg.det(left @ right)[..., None]
    result[beyond] = (left * np.clip(stretches, LEAST_STRETCH, LARGEST_STRETCH)[..., None, :]) @ right
    return result


def _within_limits(gradients: FloatArray) -> Flags:
    """Whether (...) gradients F turn nothing inside out and F^T F has its eigenvalues between the squared limits."""
    squares = np.swapaxes(gradients, -1, -2) @ gradients
    least, largest = LEAST_STRETCH**2 * np.eye(3), LARGEST_STRETCH**2 * np.eye(3)
    upright = _determinants(gradients) > 0.0
    return np.asarray(upright & _positive_definite(squares - least) & _positive_definite(largest - squares))


def _positive_definite(matrices: FloatArray) -> Flags:
    """Whether symmetric matrices (..., 3, 3) are, by their leading minors (Sylvester)."""
    first = matrices[..., 0, 0]
    second = first * matrices[..., 1, 1] - matrices[..., 0, 1] * matrices[..., 1, 0]
    return np.asarray((first > 0.0) & (second > 0.0) & (_determinants(matrices) > 0.0))


def _determinants(matrices: FloatArray) -> FloatArray:
    """Determinants (...) of matrices (..., 3, 3): several times as fast as by factorisation."""
    columns = np.moveaxis(matrices, -1, 0)
    return np.asarray(np.einsum("...i,...i->...", columns[0], np.cross(columns[1], columns[2])))
