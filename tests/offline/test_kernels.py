"""Forces are the derivative of the energy, the tangent that of the forces; both agree with scikit-fem's own forms."""

import numpy as np
import pytest
import scipy.sparse as sp
import skfem

from risorius.mechanics.material import Yeoh
from risorius_offline.elements import ELEMENTS
from risorius_offline.full_model import FullModel
from risorius_offline.tangents import PROJECTED, TRUE
from tests.offline.meshes import box
from tests.offline.models import block_anatomy, muscle_block

MATERIAL = Yeoh(c10=2500.0, c20=1175.0, bulk=250e3)
CASES = [(cell_type, mean) for cell_type in sorted(ELEMENTS) for mean in (True, False)]


def deformed_model(cell_type, mean_dilatation, amplitude=6e-4):
    model = FullModel(
        muscle_block(cell_type, MATERIAL), mean_dilatation=mean_dilatation, walled=False, solver="superlu"
    )
    model.set_parameters(np.array([0.7]))
    u = np.random.default_rng(3).normal(size=model.anatomy.points.shape) * amplitude
    return model, u


def full_tangent(model, u, *, project=False):
    pattern = model.discretisation.pattern
    values, _ = model.tangent(u, PROJECTED if project else TRUE)
    upper = sp.csr_matrix((values, pattern.indices, pattern.indptr), pattern.shape)
    return (upper + sp.triu(upper, 1).T).toarray()


@pytest.mark.parametrize(("cell_type", "mean_dilatation"), CASES)
def test_forces_are_the_derivative_of_the_energy(cell_type, mean_dilatation):
    model, u = deformed_model(cell_type, mean_dilatation)
    direction = np.random.default_rng(4).normal(size=u.shape)
    h = 1e-8
    difference = (model.energy(u + h * direction) - model.energy(u - h * direction)) / (2 * h)
    _, smallest, forces = model.forces(u)
    assert smallest > 0
    assert (forces * direction).sum() == pytest.approx(difference, rel=1e-6)


@pytest.mark.parametrize(("cell_type", "mean_dilatation"), CASES)
def test_tangent_is_the_derivative_of_the_forces(cell_type, mean_dilatation):
    model, u = deformed_model(cell_type, mean_dilatation)
    direction = np.random.default_rng(5).normal(size=u.shape)
    h = 2e-9
    plus, minus = model.forces(u + h * direction)[2], model.forces(u - h * direction)[2]
    difference = ((plus - minus) / (2 * h)).ravel()
    product = full_tangent(model, u) @ direction.ravel()
    assert np.linalg.norm(product - difference) < 1e-7 * np.linalg.norm(difference)


@pytest.mark.parametrize("cell_type", sorted(ELEMENTS))
def test_projected_tangent_is_positive_semidefinite_where_the_true_one_is_not(cell_type):
    model, u = deformed_model(cell_type, True, amplitude=5e-4)
    u[:, 0] *= 0.4
    u[:, 2] -= 0.45 * model.anatomy.points[:, 2]
    assert model.energy(u) < np.inf
    true, projected = (
        np.linalg.eigvalsh(full_tangent(model, u)),
        np.linalg.eigvalsh(full_tangent(model, u, project=True)),
    )
    assert true[0] < -1e-6 * true[-1]
    assert projected[0] > -1e-9 * projected[-1]


def test_inverted_state_has_infinite_energy_and_tells_its_jacobian():
    model, u = deformed_model("hexahedron", True)
    u[:, 0] -= 1.5 * model.anatomy.points[:, 0]
    energy, smallest, _ = model.forces(u)
    assert energy == np.inf
    assert smallest < 0


def test_rigid_rotation_turns_forces_along_and_keeps_the_energy():
    model, u = deformed_model("hexahedron", True)
    angle = 0.8
    rotation = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    turned = (model.anatomy.points + u) @ rotation.T - model.anatomy.points
    energy, _, forces = model.forces(u)
    turned_energy, _, turned_forces = model.forces(turned)
    assert turned_energy == pytest.approx(energy, rel=1e-12)
    np.testing.assert_allclose(turned_forces, forces @ rotation.T, atol=1e-10 * np.abs(forces).max())


def test_forces_equal_those_of_scikit_fem():
    points, cells = box("tetra", distortion=0.2)
    material = Yeoh.neo_hookean(15e3, 0.45)
    model = FullModel(block_anatomy(points, cells, material), mean_dilatation=False, solver="superlu")
    model.set_parameters(np.zeros(0))
    u = np.random.default_rng(6).normal(size=points.shape) * 4e-4
    mesh = skfem.MeshTet(points.T, cells.connectivity.T)
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTetP1()), intorder=1)
    mu, lam = 2 * material.c10, material.lame

    @skfem.LinearForm
    def internal(v, w):
        F = w["u"].grad + np.eye(3)[:, :, None, None]
        inverse_transposed = np.moveaxis(np.linalg.inv(np.moveaxis(F, (0, 1), (-2, -1))), (-1, -2), (0, 1))
        J = np.linalg.det(np.moveaxis(F, (0, 1), (-2, -1)))
        P = mu * (F - inverse_transposed) + lam * np.log(J) * inverse_transposed
        return np.einsum("ij...,ij...->...", P, v.grad)

    field = np.zeros(basis.N)
    field[basis.nodal_dofs] = u.T
    expected = internal.assemble(basis, u=basis.interpolate(field))[basis.nodal_dofs].T
    np.testing.assert_allclose(model.forces(u)[2], expected, atol=1e-12 * np.abs(expected).max())
