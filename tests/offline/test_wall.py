"""Walls keep J > 0 everywhere in a cell, and are not felt by cells that are not squeezed."""

import numpy as np
import pytest
import scipy.sparse as sp

from risorius.mechanics.material import Yeoh
from risorius_offline.bernstein import bernstein_form
from risorius_offline.discretisation import Discretisation
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel
from risorius_offline.jacobian_bounds import jacobian_bounds
from risorius_offline.wall import HEIGHT, walls
from tests.offline.hard_attempts import HardCase
from tests.offline.hard_cheek import cheek_cases
from tests.offline.meshes import box

TISSUE = Yeoh.neo_hookean(15e3, 0.45)
CELL_TYPES = ["hexahedron", "wedge", "tetra10"]


def squeezed(cell_type, left=0.3, noise=1e-4):
    """A distorted block, its wall, and a displacement that leaves part of its height."""
    points, cells = box(cell_type, (2, 2, 2), (0.02,) * 3, 0.1)
    discretisation = Discretisation(points, [cells])
    (wall,) = walls(discretisation, (TISSUE,))
    u = np.random.default_rng(2).normal(scale=noise, size=points.shape)
    u[:, 2] -= (1.0 - left) * points[:, 2]
    return discretisation, wall, u


def forces(wall, u):
    result = np.zeros_like(u)
    wall.add_forces(u, result)
    return result


def tangent(discretisation, wall, u, project=False):
    pattern = discretisation.pattern
    values = np.zeros(pattern.nnz)
    wall.add_tangent(u, project, values)
    upper = sp.csr_matrix((values, pattern.indices, pattern.indptr), pattern.shape)
    return (upper + sp.triu(upper, 1).T).toarray()


@pytest.mark.parametrize("cell_type", CELL_TYPES)
def test_forces_are_the_derivative_of_the_energy(cell_type):
    _, wall, u = squeezed(cell_type)
    direction = np.random.default_rng(3).normal(size=u.shape)
    h = 1e-9
    difference = (wall.energy(u + h * direction) - wall.energy(u - h * direction)) / (2 * h)
    assert wall.energy(u) > 0.0
    assert (forces(wall, u) * direction).sum() == pytest.approx(difference, rel=1e-6)


@pytest.mark.parametrize("cell_type", CELL_TYPES)
def test_tangent_is_the_derivative_of_the_forces(cell_type):
    discretisation, wall, u = squeezed(cell_type)
    direction = np.random.default_rng(4).normal(size=u.shape)
    h = 1e-9
    difference = ((forces(wall, u + h * direction) - forces(wall, u - h * direction)) / (2 * h)).ravel()
    product = tangent(discretisation, wall, u) @ direction.ravel()
    assert np.linalg.norm(product - difference) < 1e-7 * np.linalg.norm(difference)


@pytest.mark.parametrize("cell_type", CELL_TYPES)
def test_projected_tangent_is_positive_semidefinite_where_the_true_one_is_not(cell_type):
    discretisation, wall, u = squeezed(cell_type)
    true, projected = (np.linalg.eigvalsh(tangent(discretisation, wall, u, project)) for project in (False, True))
    assert true[0] < -1e-6 * true[-1]
    assert projected[0] > -1e-12 * projected[-1]


@pytest.mark.parametrize("cell_type", CELL_TYPES)
def test_a_cell_that_keeps_more_than_the_height_of_the_wall_does_not_feel_it(cell_type):
    _, wall, u = squeezed(cell_type, left=1.01 * HEIGHT, noise=0.0)
    assert wall.energy(u) == 0.0
    assert not forces(wall, u).any()
    _, wall, u = squeezed(cell_type, left=0.9 * HEIGHT, noise=0.0)
    assert wall.energy(u) > 0.0


@pytest.mark.parametrize("cell_type", CELL_TYPES)
def test_jacobians_are_positive_everywhere_where_the_energy_is_finite(cell_type):
    discretisation, wall, _ = squeezed(cell_type)
    rng = np.random.default_rng(5)
    admissible = []
    for _ in range(100):
        u = rng.normal(scale=rng.uniform(2e-4, 6e-3), size=discretisation.points.shape)
        admissible.append(np.isfinite(wall.energy(u)))
        assert not admissible[-1] or jacobian_bounds(discretisation, u).positive
    assert 5 < sum(admissible) < 95


def test_a_corner_that_no_quadrature_point_sees_inverted_has_infinite_energy():
    points, cells = box("hexahedron", (1, 1, 1), (0.02,) * 3)
    discretisation = Discretisation(points, [cells])
    (wall,) = walls(discretisation, (TISSUE,))
    u = np.zeros_like(points)
    u[-1, 2] = -0.031
    assert np.linalg.det(discretisation.volumes[0].deformation_gradients(u)).min() > 0.0
    assert wall.energy(u) == np.inf


def test_a_cell_with_negative_coefficients_but_a_positive_determinant_at_rest_is_divided():
    points, cells = box("hexahedron", (1, 1, 1), (1.0, 1.0, 1.0))
    rng, bernstein = np.random.default_rng(0), bernstein_form("hexahedron")
    moved, coefficients = Discretisation(points, [cells]), np.ones(1)
    while not (coefficients.min() < 0.0 and jacobian_bounds(moved, np.zeros_like(points)).positive):
        moved = Discretisation(points + rng.uniform(-0.4, 0.4, size=points.shape), [cells])
        coefficients = bernstein.coefficients(moved.points[cells.connectivity])
    (wall,) = walls(moved, (TISSUE,))
    assert len(wall.form) > len(bernstein.form)
    assert (wall.heights > 0.0).all()
    assert wall.energy(np.zeros_like(points)) == 0.0


def test_linear_tetrahedra_need_no_wall():
    points, cells = box("tetra", (1, 1, 1))
    assert walls(Discretisation(points, [cells]), (TISSUE,)) == ()


def test_strong_muscles_leave_every_cell_with_positive_jacobians_but_not_without_walls():
    case: HardCase = next(case for case in cheek_cases() if case.name == "cheek: all muscles at 1")
    anatomy = case.build().anatomy
    for walled in (True, False):
        model = FullModel(anatomy, walled=walled)
        u = EquilibriumSolver(model).solve(case.parameters(anatomy.inputs)).u
        assert jacobian_bounds(model.discretisation, u).positive == walled
