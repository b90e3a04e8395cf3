"""Gravity and skin pre-stress against theory."""

import numpy as np
import pytest

from risorius.mechanics.material import TISSUE_DENSITY, Yeoh
from risorius_offline.discretisation import Discretisation
from risorius_offline.effects import DeadLoad
from risorius_offline.effects.gravity import UPRIGHT, gravity
from risorius_offline.effects.skin_prestress import SKIN_THICKNESS, SkinPrestress
from risorius_offline.elements import ELEMENTS
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel
from tests.offline.meshes import box
from tests.offline.models import block_anatomy

LYING = (0.0, 0.0, -9.81)


@pytest.mark.parametrize("cell_type", sorted(ELEMENTS))
def test_weight_is_mass_times_the_change_of_gravity_and_acts_at_the_centre(cell_type):
    points, cells = box(cell_type, distortion=0.2)
    load = gravity(Discretisation(points, [cells]), LYING, UPRIGHT).nodal_forces
    mass = TISSUE_DENSITY * 0.02**3
    np.testing.assert_allclose(load.sum(axis=0), mass * np.array([0.0, 9.81, -9.81]), rtol=1e-12, atol=1e-15)
    moment = np.cross(points - 0.01, load).sum(axis=0)
    np.testing.assert_allclose(moment, 0.0, atol=1e-12 * mass * 9.81 * 0.02)


def test_an_upright_face_taken_upright_does_not_sag():
    points, cells = box("hexahedron")
    assert not gravity(Discretisation(points, [cells]), UPRIGHT, UPRIGHT).nodal_forces.any()


def test_a_column_shortens_under_its_weight_as_theory_says():
    """Confined column of height h: top moves by rho g h^2 / (2 (lam + 2 mu)), for small strains."""
    material = Yeoh.neo_hookean(15e3, 0.3)
    points, cells = box("hexahedron", cells=(1, 1, 8), size=(0.01, 0.01, 0.02))
    load = gravity(Discretisation(points, [cells]), LYING, (0.0, 0.0, 0.0))
    model = FullModel(block_anatomy(points, cells, material), [load], solver="superlu")
    held = np.ones_like(points, dtype=bool)
    held[:, 2] = points[:, 2] == 0.0
    model.free, model.prescribed = np.flatnonzero(~held.ravel()), np.flatnonzero(held.ravel())
    u = EquilibriumSolver(model, tolerance=1e-11).solve(np.zeros(0)).u
    stiffness = material.lame + 4.0 * material.c10
    theory = -TISSUE_DENSITY * 9.81 * 0.02**2 / (2 * stiffness)
    assert u[points[:, 2].argmax(), 2] == pytest.approx(theory, rel=2 * abs(theory) / 0.02)  # second order in strain


def strip(cells):
    """Triangles of a flat strip 20 x 5 mm in the plane z = 0."""
    x, y = np.meshgrid(np.linspace(0, 0.02, cells + 1), [0.0, 0.005], indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    corner = 2 * np.arange(cells)
    lower = np.column_stack([corner, corner + 2, corner + 3])
    upper = np.column_stack([corner, corner + 3, corner + 1])
    return points, np.concatenate([lower, upper])


def test_a_stretched_strip_carries_a_lateral_load_as_a_string_does():
    """String of tension S under a line load q, held at both ends: deflection q x (l - x) / (2 S), nodally exact."""
    points, skin = strip(10)
    stress, line_load = 20e3, 0.3
    effect = SkinPrestress(points, skin, stress)
    blocks = effect.second_derivatives(np.zeros_like(points), project=False)
    stiffness = np.zeros((points.size, points.size))
    for nodes, matrix in zip(blocks.nodes, blocks.matrices, strict=True):
        dofs = (3 * nodes[:, None] + np.arange(3)).ravel()
        stiffness[np.ix_(dofs, dofs)] += matrix
    load = np.zeros_like(points)
    load[:, 2] = line_load * 0.02 / 10 / 2
    inside = np.flatnonzero(np.repeat((points[:, 0] > 0) & (points[:, 0] < 0.02 - 1e-12), 3))
    u = np.zeros(points.size)
    u[inside] = np.linalg.solve(stiffness[np.ix_(inside, inside)], load.ravel()[inside])
    tension = stress * SKIN_THICKNESS * 0.005
    theory = line_load * points[:, 0] * (0.02 - points[:, 0]) / (2 * tension)
    np.testing.assert_allclose(u.reshape(-1, 3)[:, 2], theory, atol=1e-9 * theory.max())


def test_prestress_leaves_the_shape_at_rest_alone_and_its_forces_are_those_of_its_energy():
    points, skin = strip(4)
    effect = SkinPrestress(points, skin, 10e3)
    rng = np.random.default_rng(1)
    u, direction, forces = rng.normal(size=points.shape), rng.normal(size=points.shape), np.zeros_like(points)
    assert effect.energy(np.zeros_like(points)) == 0.0
    assert effect.add_forces(u, forces) == pytest.approx(effect.energy(u))
    difference = (effect.energy(u + direction) - effect.energy(u - direction)) / 2  # exact: the energy is quadratic
    assert (forces * direction).sum() == pytest.approx(difference, rel=1e-10)


def test_prestress_stiffens_the_skin_against_a_pull():
    points, cells = box("hexahedron", cells=(4, 4, 2), size=(0.02, 0.02, 0.006))
    anatomy = block_anatomy(points, cells, Yeoh(2500.0, 1175.0, 250e3))
    top = np.isclose(points[:, 2], 0.006)
    skin = anatomy.skin[top[anatomy.skin].all(axis=1)]
    middle = np.linalg.norm(points - [0.01, 0.01, 0.006], axis=1).argmin()
    load = np.zeros_like(points)
    load[middle, 2] = 0.05
    lifts = []
    for stress in (0.0, 10e3, 40e3):
        model = FullModel(anatomy, [DeadLoad(load), SkinPrestress(points, skin, stress)], solver="superlu")
        found = EquilibriumSolver(model).solve(np.zeros(0))
        lifts.append(found.u[middle, 2])
    assert lifts[0] > lifts[1] > lifts[2] > 0.0
