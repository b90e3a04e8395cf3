import numpy as np
import pytest
import scipy.sparse as sp

from risorius.errors import InputError
from risorius.mechanics.material import Yeoh
from risorius_offline.discretisation import Discretisation
from risorius_offline.elements import ELEMENTS
from risorius_offline.full_model import FullModel
from risorius_offline.inertia import Inertia, Medium, mass_values
from tests.offline.meshes import box
from tests.offline.models import muscle_block

TYPES = sorted(ELEMENTS)
SIZE = (0.02, 0.03, 0.05)
DENSITY = 1040.0
MASS = DENSITY * np.prod(SIZE)


def mass_matrix(points, cells):
    discretisation = Discretisation(points, [cells])
    pattern = discretisation.pattern
    upper = sp.csr_matrix((mass_values(discretisation, DENSITY), pattern.indices, pattern.indptr), pattern.shape)
    return (upper + sp.triu(upper, 1).T).toarray()


@pytest.mark.parametrize("cell_type", TYPES)
def test_kinetic_energy_of_a_translation_is_that_of_the_mass_also_on_distorted_cells(cell_type):
    points, cells = box(cell_type, size=SIZE, distortion=0.2)
    velocity = np.tile([0.3, -0.2, 0.6], len(points))
    assert velocity @ mass_matrix(points, cells) @ velocity == pytest.approx(0.49 * MASS, rel=1e-12)


@pytest.mark.parametrize("cell_type", TYPES)
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_moment_of_inertia_of_a_box(cell_type, axis):
    """m (a^2 + b^2) / 12 about the axis through the centre."""
    points, cells = box(cell_type, size=SIZE)
    velocity = np.cross(np.eye(3)[axis], points - 0.5 * np.array(SIZE)).ravel()
    expected = MASS * (np.dot(SIZE, SIZE) - SIZE[axis] ** 2) / 12
    assert velocity @ mass_matrix(points, cells) @ velocity == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("cell_type", TYPES)
def test_mass_matrix_is_positive_definite(cell_type):
    points, cells = box(cell_type, size=SIZE, distortion=0.2)
    eigenvalues = np.linalg.eigvalsh(mass_matrix(points, cells))
    assert eigenvalues[0] > 1e-3 * eigenvalues[-1]


def test_metric_is_rate_squared_mass_and_rate_rayleigh_damping():
    points, cells = box("wedge", distortion=0.2)
    discretisation = Discretisation(points, [cells])
    rng = np.random.default_rng(0)
    stiffness, v = rng.normal(size=discretisation.pattern.nnz), rng.normal(size=points.shape)
    inertia = Inertia(discretisation, Medium(DENSITY, 3.0, 0.02))
    values, whole = inertia.metric(10.0, stiffness)
    mass = mass_matrix(points, cells)
    np.testing.assert_allclose(values, 130.0 * mass_values(discretisation, DENSITY) + 0.2 * stiffness, rtol=1e-13)
    np.testing.assert_array_equal(whole.toarray(), whole.toarray().T)
    pattern = discretisation.pattern
    upper = sp.csr_matrix((values, pattern.indices, pattern.indptr), pattern.shape).toarray()
    np.testing.assert_array_equal(np.triu(whole.toarray()), upper)
    assert inertia.kinetic_energy(v) == pytest.approx(0.5 * v.ravel() @ mass @ v.ravel())


def test_stiffness_for_damping_is_that_of_the_tissue_without_activation_and_leaves_the_activation():
    model = FullModel(muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3)), solver="superlu")
    u = np.random.default_rng(1).normal(size=model.anatomy.points.shape) * 1e-4
    model.set_parameters(np.array([1.0]))
    energy, passive = model.energy(u), model.passive_stiffness(u)
    assert model.energy(u) == energy
    assert not np.allclose(model.tissue.tangent(u), passive)
    model.set_parameters(np.array([0.0]))
    np.testing.assert_array_equal(model.tissue.tangent(u), passive)


@pytest.mark.parametrize("wrong", [{"density": 0.0}, {"mass_damping": -1.0}, {"stiffness_damping": -1.0}])
def test_medium_without_mass_or_with_negative_damping_is_refused(wrong):
    with pytest.raises(InputError, match=r"medium: .*give a positive density and damping of at least 0"):
        Medium(**wrong)
