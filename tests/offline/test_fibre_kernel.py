"""Fibres by both laws: derivatives, equality with the active tensors of the elements, and a bar by hand."""

import numpy as np
import pytest
import scipy.sparse as sp

from risorius.mechanics import elements, fibres
from risorius.mechanics.fibres import HILL, PROPORTIONAL, FibrePoints
from risorius_offline.discretisation import Discretisation
from risorius_offline.elements import ELEMENTS
from risorius_offline.muscles.polyline_fibres import PolylineFibres
from tests.offline.meshes import box

LAWS = [PROPORTIONAL, HILL]
ACTIVATIONS = np.array([0.7, 0.4])
STRESS = 50e3
LINES = (
    np.array([[0.0, 0.01, 0.01], [0.02, 0.01, 0.012]]),
    np.array([[0.01, 0.0, 0.01], [0.012, 0.02, 0.009]]),
)


def two_muscles(cell_type="hexahedron"):
    """A 20 mm cube with two muscles that cross in its middle: discretisation, block arrays, fibre points."""
    points, cells = box(cell_type, distortion=0.2)
    discretisation = Discretisation(points, [cells])
    block = discretisation.blocks[0]
    found = [PolylineFibres((line,), 0.006).field(discretisation) for line in LINES]
    inside = np.concatenate([field.points for field in found])
    element, point = np.divmod(inside, block.weights.shape[1])
    muscle = np.repeat([0, 1], [len(field.points) for field in found])
    directions = np.concatenate([field.directions for field in found])
    assert len(np.unique(inside)) < len(inside)
    listed = FibrePoints(element, point, directions, muscle, np.full(len(inside), STRESS))
    return discretisation, (block.cells.connectivity, block.gradients, block.weights), listed


def deformation(points, seed=3):
    """Lengthened along x and shortened along y, with noise."""
    return points * np.array([0.25, -0.3, 0.1]) + np.random.default_rng(seed).normal(size=points.shape) * 4e-4


def forces_at(u, arrays, listed, law):
    forces = np.zeros_like(u)
    energy = fibres.energy_and_forces(u, *arrays, listed, ACTIVATIONS, law, True, forces)
    return energy, forces


def full_tangent(u, discretisation, arrays, listed, law, *, project=False):
    pattern = discretisation.pattern
    values = np.zeros(pattern.nnz)
    fibres.tangent(u, *arrays, listed, ACTIVATIONS, law, project, discretisation.scatter[0], values)
    upper = sp.csr_matrix((values, pattern.indices, pattern.indptr), pattern.shape)
    return (upper + sp.triu(upper, 1).T).toarray()


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("cell_type", sorted(ELEMENTS))
def test_forces_are_the_derivative_of_the_energy(cell_type, law):
    discretisation, arrays, listed = two_muscles(cell_type)
    u = deformation(discretisation.points)
    direction = np.random.default_rng(4).normal(size=u.shape)
    h = 1e-8
    plus, minus = (forces_at(u + s * direction, arrays, listed, law)[0] for s in (h, -h))
    expected = (plus - minus) / (2 * h)
    assert (forces_at(u, arrays, listed, law)[1] * direction).sum() == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("cell_type", sorted(ELEMENTS))
def test_tangent_is_the_derivative_of_the_forces(cell_type, law):
    discretisation, arrays, listed = two_muscles(cell_type)
    u = deformation(discretisation.points)
    direction = np.random.default_rng(5).normal(size=u.shape)
    h = 1e-7
    plus, minus = (forces_at(u + s * direction, arrays, listed, law)[1] for s in (h, -h))
    expected = ((plus - minus) / (2 * h)).ravel()
    product = full_tangent(u, discretisation, arrays, listed, law) @ direction.ravel()
    assert np.linalg.norm(product - expected) < 1e-7 * np.linalg.norm(expected)


def test_proportional_law_equals_active_tensors_of_the_elements():
    discretisation, arrays, listed = two_muscles()
    u = deformation(discretisation.points)
    x, y, z = listed.direction.T
    tensors = (listed.stress * ACTIVATIONS[listed.muscle])[:, None] * np.stack(
        [x * x, y * y, z * z, x * y, y * z, z * x], axis=1
    )
    active = np.zeros((*arrays[2].shape, 6))
    np.add.at(active, (listed.element, listed.point), tensors)
    passive = np.zeros((len(arrays[0]), 3))
    expected = np.zeros_like(u)
    expected_energy, _ = elements.energy_and_forces(u, *arrays, passive, active, True, True, expected)
    energy, forces = forces_at(u, arrays, listed, PROPORTIONAL)
    assert energy == pytest.approx(expected_energy, rel=1e-12)
    np.testing.assert_allclose(forces, expected, atol=1e-12 * np.abs(expected).max())
    pattern = discretisation.pattern
    expected_values, values = np.zeros(pattern.nnz), np.zeros(pattern.nnz)
    elements.tangent(u, *arrays, passive, active, True, False, discretisation.scatter[0], expected_values)
    fibres.tangent(u, *arrays, listed, ACTIVATIONS, PROPORTIONAL, False, discretisation.scatter[0], values)
    np.testing.assert_allclose(values, expected_values, atol=1e-12 * np.abs(expected_values).max())


@pytest.mark.parametrize("law", LAWS)
def test_law_is_the_derivative_of_its_energy_and_has_its_own_derivative(law):
    h = 1e-6
    for stretch in np.linspace(0.3, 1.8, 16):
        above, below = fibres.force_length(law, stretch + h), fibres.force_length(law, stretch - h)
        _, f, slope = fibres.force_length(law, stretch)
        assert f == pytest.approx((above[0] - below[0]) / (2 * h), rel=1e-8)
        assert slope == pytest.approx((above[1] - below[1]) / (2 * h), rel=1e-8, abs=1e-9)


def test_hill_curve_is_best_at_rest_length():
    stretches = np.linspace(0.5, 1.5, 101)
    curve = np.array([fibres.force_length(HILL, stretch)[1] for stretch in stretches])
    assert stretches[curve.argmax()] == pytest.approx(1.0)
    assert curve.max() == 1.0
    # Thelen 2003: exp(-0.25 / 0.45) at half and at one and a half times the best length.
    np.testing.assert_allclose(curve[[0, -1]], 0.5737534207374328, rtol=1e-12)


@pytest.mark.parametrize("law", LAWS)
def test_columns_are_the_derivatives_of_the_forces_by_activation(law):
    discretisation, arrays, listed = two_muscles()
    u = deformation(discretisation.points)
    columns = np.zeros((*u.shape, 2))
    fibres.add_muscle_forces(u, *arrays, listed, law, columns)
    forces = forces_at(u, arrays, listed, law)[1]
    np.testing.assert_allclose(columns @ ACTIVATIONS, forces, atol=1e-13 * np.abs(forces).max())
    assert np.abs(columns).max(axis=(0, 1)).min() > 0


def test_projected_tangent_is_positive_semidefinite_on_the_descending_limb():
    discretisation, arrays, listed = two_muscles()
    u = 0.4 * discretisation.points
    true = np.linalg.eigvalsh(full_tangent(u, discretisation, arrays, listed, HILL))
    projected = np.linalg.eigvalsh(full_tangent(u, discretisation, arrays, listed, HILL, project=True))
    assert true[0] < -1e-3 * true[-1]
    assert projected[0] > -1e-12 * projected[-1]


@pytest.mark.parametrize("stretch", [0.7, 1.0, 1.3])
def test_bar_pulls_with_the_hill_stress_times_its_area(stretch):
    length, side = 0.03, 0.01
    points, cells = box("hexahedron", cells=(3, 1, 1), size=(length, side, side))
    block = Discretisation(points, [cells]).blocks[0]
    element, point = (index.ravel() for index in np.indices(block.weights.shape))
    count = len(element)
    directions = np.tile([1.0, 0.0, 0.0], (count, 1))
    listed = FibrePoints(element, point, directions, np.zeros(count, dtype=np.int64), np.full(count, STRESS))
    arrays = (block.cells.connectivity, block.gradients, block.weights)
    u = np.zeros_like(points)
    u[:, 0] = (stretch - 1.0) * points[:, 0]
    forces, sums, a = np.zeros_like(u), np.zeros((1, 4)), np.array([0.6])
    energy = fibres.energy_and_forces(u, *arrays, listed, a, HILL, True, forces)
    fibres.add_integrals(u, *arrays, listed, a, HILL, sums)
    stress = 0.6 * STRESS * np.exp(-((stretch - 1.0) ** 2) / 0.45)
    assert forces[points[:, 0] > 0.029, 0].sum() == pytest.approx(stress * side**2, rel=1e-12)
    volume = length * side**2
    np.testing.assert_allclose(sums[0], [volume, volume * stretch, stress * volume, -energy], rtol=1e-12, atol=1e-15)
