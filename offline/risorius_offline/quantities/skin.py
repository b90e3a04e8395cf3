"""Strain and stress of the skin, triangle by triangle, in the tissue behind it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from risorius.errors import SolverError
from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray, film, triangle_owners
from risorius_offline.full_model import FullModel
from risorius_offline.quantities.stress import cauchy_stress, principal_stresses, von_mises


@dataclass(frozen=True)
class SkinState:
    """Stretch in the plane of the skin triangles (m, 3) at their centroids, and stress in the tissue behind them.

    areas (m,): at rest, square metres. stretches (m, 2): principal, the larger first. directions (m, 2, 3): of the
    principal stretches, unit vectors in the plane of the triangle at rest. stress (m, 3, 3): Cauchy, pascals, of the
    passive tissue: without active stress and without effects such as a pre-stress of the skin.
    """

    triangles: IntArray
    areas: FloatArray
    stretches: FloatArray
    directions: FloatArray
    stress: FloatArray

    @property
    def strains(self) -> FloatArray:
        """(m, 2) principal Green-Lagrange strains (stretch^2 - 1) / 2, the larger first."""
        return 0.5 * (self.stretches**2 - 1.0)

    @property
    def area_ratios(self) -> FloatArray:
        """(m,) deformed area over area at rest."""
        return self.stretches.prod(axis=1)

    @property
    def principal_stresses(self) -> FloatArray:
        """(m, 3) pascals, the largest first."""
        return principal_stresses(self.stress)

    @property
    def von_mises(self) -> FloatArray:
        """(m,) equivalent stress, pascals."""
        return von_mises(self.stress)

    @property
    def vertices(self) -> IntArray:
        """(v,) numbers of the nodes of the skin, ascending."""
        return np.unique(self.triangles)

    def at_vertices(self, values: FloatArray) -> FloatArray:
        """(v, ...) mean of triangle values (m, ...) over the triangles around each of `vertices`, weighted by area."""
        numbers = np.searchsorted(self.vertices, self.triangles)
        total, area = np.zeros((len(self.vertices), *values.shape[1:])), np.zeros(len(self.vertices))
        weights = self.areas.reshape(-1, *[1] * (values.ndim - 1))
        for corner in range(3):
            np.add.at(total, numbers[:, corner], weights * values)
            np.add.at(area, numbers[:, corner], self.areas)
        return total / area.reshape(-1, *[1] * (values.ndim - 1))


def skin_state(model: FullModel, u: FloatArray) -> SkinState:
    """State of the skin at a displacement u (n, 3) in metres; raises SolverError where a triangle is folded (J <= 0).

    The stress takes the pressure of the element's mean J, as the energy of the model does.
    """
    triangles = model.anatomy.skin
    F, dilatation, coefficients, areas = _behind(model, u)
    jacobian = np.linalg.det(F)
    folded = np.flatnonzero(jacobian <= 0.0)
    if len(folded):
        raise SolverError(
            f"{len(folded)} skin triangle(s) are folded, first triangle {folded[0]} with "
            f"J = {jacobian[folded[0]]:.3g}; give the anatomy an epidermis or lower the activations"
        )
    tangents = _tangents(model.anatomy.points[triangles])
    plane = np.einsum("mij,mjk->mik", F, tangents)
    squares, axes = np.linalg.eigh(np.einsum("mij,mik->mjk", plane, plane))
    return SkinState(
        triangles=triangles,
        areas=areas,
        stretches=np.sqrt(squares[:, ::-1]),
        directions=np.einsum("mij,mjk->mki", tangents, axes[:, :, ::-1]),
        stress=cauchy_stress(F, dilatation if model.tissue.mean_dilatation else jacobian, coefficients),
    )


def _behind(model: FullModel, u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Of every skin triangle (m): F (m, 3, 3) at its centroid, mean J and coefficients (m, 3) of its cell, area."""
    triangles, count = model.anatomy.skin, len(model.anatomy.skin)
    F, dilatation = np.zeros((count, 3, 3)), np.zeros(count)
    coefficients, areas = np.zeros((count, 3)), np.zeros(count)
    by_layer = np.array([material.coefficients for material in model.anatomy.materials])
    for block in model.discretisation.volumes:
        owners = triangle_owners(block.cells, triangles)
        numbers, cells = np.array([owner[:2] for owner in owners], dtype=np.int64).reshape(-1, 2).T
        surface = film(model.discretisation.points, block.cells, triangles, thickness=1.0)
        F[numbers] = surface.deformation_gradients(u)[:, 0]
        dilatation[numbers] = block.mean_jacobians(u)[cells]
        coefficients[numbers] = by_layer[surface.cells.layer]
        areas[numbers] = surface.weights[:, 0]
    return F, dilatation, coefficients, areas


def _tangents(corners: FloatArray) -> FloatArray:
    """(m, 3, 2) orthonormal pairs in the planes of triangles with corners (m, 3, 3)."""
    along, across = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    first = along / np.linalg.norm(along, axis=1, keepdims=True)
    second = across - (across * first).sum(axis=1, keepdims=True) * first
    return np.stack([first, second / np.linalg.norm(second, axis=1, keepdims=True)], axis=2)
