"""Manufactured solutions on the unit cube: a field, the body force it needs, and the error of a computed field."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.discretisation import CellBlock
from risorius_offline.effects import DeadLoad
from risorius_offline.elements.reference import gauss
from risorius_offline.equilibrium import Equilibrium, EquilibriumSolver
from risorius_offline.full_model import FullModel
from tests.offline.meshes import box
from tests.offline.models import block_anatomy

FINE_ORDER = 6  # of the rule for loads and errors: its own error is far below that of the elements
COMPLEX_STEP = 1e-30


@dataclass(frozen=True)
class Field:
    """A displacement (..., 3) of positions (..., 3) and its gradient (..., 3, 3), for real and complex positions."""

    displacement: Callable[[np.ndarray], np.ndarray]
    gradient: Callable[[np.ndarray], np.ndarray]


def _bubble(x):
    return np.prod(np.sin(np.pi * x), axis=-1)


def _bubble_gradient(x):
    s, c = np.sin(np.pi * x), np.pi * np.cos(np.pi * x)
    return np.stack([c[..., i] * s[..., (i + 1) % 3] * s[..., (i + 2) % 3] for i in range(3)], axis=-1)


_PUSH, _TWIST = np.array([0.08, -0.05, 0.06]), np.array([[0.0, 0.06, 0.05], [-0.08, 0.04, 0.0], [0.0, -0.06, -0.05]])

# Zero on the surface of the cube; strains up to 40 %, J from 0.5 to 1.5.
SWIRL = Field(
    displacement=lambda x: _bubble(x)[..., None] * (_PUSH + x @ _TWIST.T),
    gradient=lambda x: (
        (_PUSH + x @ _TWIST.T)[..., :, None] * _bubble_gradient(x)[..., None, :] + _bubble(x)[..., None, None] * _TWIST
    ),
)


def _shear_gradient(x):
    gradient = np.zeros((*x.shape, 3), dtype=x.dtype)
    gradient[..., 0, :] = 0.15 * _bubble_gradient(np.where([True, False, False], 0.5, x))
    return gradient


# Keeps every volume (J = 1) and so needs no pressure: its body force does not depend on Poisson's ratio.
SHEAR = Field(
    displacement=lambda x: 0.15 * _bubble(np.where([True, False, False], 0.5, x))[..., None] * np.array([1.0, 0, 0]),
    gradient=_shear_gradient,
)


class DirichletModel(FullModel):
    """A full model whose fixed nodes take given displacements (n, 3)."""

    def __init__(self, anatomy: Anatomy, boundary: np.ndarray, effects=(), **options) -> None:
        super().__init__(anatomy, effects, **options)
        self._boundary = boundary

    def prescribed_motion(self, parameters):
        return self._boundary


def on_surface(points, size=(1.0, 1.0, 1.0)):
    """Flags (n,) of the nodes on the surface of a box from the origin."""
    return (np.isclose(points, 0.0) | np.isclose(points, size)).any(axis=1)


def relative_errors(field: Field, material: Yeoh, cell_type: str, cells: int, *, mean_dilatation: bool):
    """Errors in L2 and in the H1 seminorm, relative to the field, of its finite-element solution on a distorted cube
    with displacements prescribed on the whole surface.
    """
    points, block = box(cell_type, cells=(cells,) * 3, size=(1.0, 1.0, 1.0), distortion=0.15)
    exact = field.displacement(points)
    anatomy = block_anatomy(points, block, material, fixed=on_surface(points))
    rule = _FineRule.of(points, block)
    load = DeadLoad(rule.nodal(_body_force(field, material, rule.positions), len(points)))
    model = DirichletModel(anatomy, exact, [load], mean_dilatation=mean_dilatation)
    u = EquilibriumSolver(model, tolerance=1e-9).solve(np.zeros(0), Equilibrium(np.zeros(0), exact)).u
    return rule.relative_error(field, u)


def _body_force(field: Field, material: Yeoh, x: np.ndarray) -> np.ndarray:
    """-Div P (..., 3), N/m3, by complex steps (Squire and Trapp 1998), exact to rounding."""
    force = np.zeros_like(x)
    for j in range(3):
        step = x + 1j * COMPLEX_STEP * np.eye(3)[j]
        force -= _first_piola(material, field.gradient(step))[..., j].imag / COMPLEX_STEP
    return force


def _first_piola(material: Yeoh, gradient: np.ndarray) -> np.ndarray:
    """First Piola-Kirchhoff stress (..., 3, 3) of a neo-Hookean material."""
    F = gradient + np.eye(3)
    inverse_transposed = np.swapaxes(np.linalg.inv(F), -1, -2)
    pressure = material.lame * np.log(np.linalg.det(F))[..., None, None]
    return 2.0 * material.c10 * (F - inverse_transposed) + pressure * inverse_transposed


@dataclass(frozen=True)
class _FineRule:
    """A block with a fine rule: shape functions (q, a), gradients (e, q, a, 3), weights and positions (e, q[, 3])."""

    block: CellBlock
    shapes: np.ndarray
    gradients: np.ndarray
    weights: np.ndarray
    positions: np.ndarray

    @classmethod
    def of(cls, points, block):
        element = block.element
        at, weights = gauss(element.basis, FINE_ORDER)
        shapes, reference = element.shape_functions(at), element.gradients_at(at)
        corners = points[block.connectivity]
        jacobian = np.einsum("eai,qaj->eqij", corners, reference)
        gradients = np.einsum("qaj,eqji->eqai", reference, np.linalg.inv(jacobian))
        return cls(
            block, shapes, gradients, np.linalg.det(jacobian) * weights, np.einsum("qa,eai->eqi", shapes, corners)
        )

    def nodal(self, density, count):
        """Nodal forces (count, 3) of a body force (e, q, 3)."""
        forces = np.zeros((count, 3))
        np.add.at(forces, self.block.connectivity, np.einsum("eq,qa,eqi->eai", self.weights, self.shapes, density))
        return forces

    def relative_error(self, field, u):
        """Relative L2 and H1 seminorm of the difference to a field."""
        nodal = u[self.block.connectivity]
        exact, slope = field.displacement(self.positions), field.gradient(self.positions)
        off = np.einsum("qa,eai->eqi", self.shapes, nodal) - exact
        slope_off = np.einsum("eqaj,eai->eqij", self.gradients, nodal) - slope
        return self._norm(off) / self._norm(exact), self._norm(slope_off) / self._norm(slope)

    def _norm(self, values):
        return np.sqrt((self.weights * (values**2).reshape(*self.weights.shape, -1).sum(axis=-1)).sum())
