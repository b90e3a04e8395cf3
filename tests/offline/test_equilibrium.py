from dataclasses import replace

import numpy as np
import pytest

from risorius.errors import InputError
from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy.nested_cylinders import nested_cylinders
from risorius_offline.equilibrium import Equilibrium, EquilibriumSolver, NotConvergedError
from risorius_offline.full_model import FullModel
from risorius_offline.linear_solver import SOLVERS, NotPositiveDefiniteError
from tests.offline.meshes import box
from tests.offline.models import block_anatomy, muscle_block

SIDEWAYS = np.array([0.0, 0.0, 1.0])


def dragged_block(cell_type, material, cells=(12, 12, 3), size=(0.06, 0.06, 0.012)):
    points, block = box(cell_type, cells, size)
    top = np.isclose(points[:, 2], size[2])
    near = (np.abs(points[:, :2] - 0.5 * np.array(size[:2])) <= 0.0101).all(axis=1)
    return block_anatomy(points, block, material, dragged=top & near)


@pytest.mark.parametrize("solver", ["pardiso", "superlu"])
def test_golden_value_of_the_dragged_block(solver):
    """felupe, scikit-fem and Kratos agree on this value in all digits."""
    if solver == "pardiso":
        pytest.importorskip("pypardiso")
    model = FullModel(dragged_block("tetra", Yeoh.neo_hookean(15e3, 0.45)), solver=solver)
    found = EquilibriumSolver(model, tolerance=1e-11).solve(SIDEWAYS)
    node = np.linalg.norm(model.anatomy.points - [0.045, 0.030, 0.012], axis=1).argmin()
    assert len(model.anatomy.points) == 676
    assert 1e3 * found.u[node, 0] == pytest.approx(6.1074338, abs=5e-8)


@pytest.mark.parametrize(("cell_type", "region"), [("hexahedron", "Hexahedron"), ("tetra10", "QuadraticTetra")])
def test_elements_agree_with_felupe(cell_type, region):
    felupe = pytest.importorskip("felupe")
    material = Yeoh.neo_hookean(15e3, 0.45)
    anatomy = dragged_block(cell_type, material, cells=(6, 6, 3))
    model = FullModel(anatomy, mean_dilatation=False)
    ours = EquilibriumSolver(model, tolerance=1e-12).solve(SIDEWAYS).u
    mesh = felupe.Mesh(anatomy.points, anatomy.cells[0].connectivity, cell_type)
    field = felupe.FieldContainer([felupe.Field(getattr(felupe, f"Region{region}")(mesh), dim=3)])
    theirs = felupe.SolidBody(felupe.NeoHookeCompressible(mu=2 * material.c10, lmbda=material.lame), field)
    motion = np.where(anatomy.jaw)[0]
    fixed = felupe.Boundary(field[0], mask=anatomy.skull)
    step = [
        felupe.Boundary(field[0], mask=anatomy.jaw, skip=(0, 1, 1), value=0.0),
        felupe.Boundary(field[0], mask=anatomy.jaw, skip=(1, 0, 0), value=0.0),
    ]
    bounds = felupe.BoundaryDict({"fixed": fixed, "pulled": step[0], "held": step[1]})
    ramp = felupe.math.linsteps([0, 1], num=5) * 0.008
    job = felupe.Job([felupe.Step([theirs], ramp={bounds["pulled"]: ramp}, boundaries=bounds)])
    job.evaluate(tol=1e-11, verbose=False)
    assert len(motion)
    np.testing.assert_allclose(ours, field[0].values, atol=1e-8 * np.abs(ours).max())


@pytest.mark.parametrize("cell_type", ["hexahedron", "wedge", "tetra", "tetra10"])
def test_contracting_muscle_shortens_and_every_point_keeps_its_orientation(cell_type):
    model = FullModel(muscle_block(cell_type, Yeoh(2500.0, 1175.0, 250e3)))
    found = EquilibriumSolver(model).solve(np.array([1.0]))
    assert found.report.converged
    assert found.report.residual <= 1e-6
    assert model.point_jacobians(found.u).min() > 0
    assert found.report.smallest_jacobian == pytest.approx(model.point_jacobians(found.u).min(), rel=1e-9)
    ends = [np.linalg.norm(model.anatomy.points - p, axis=1).argmin() for p in ([0, 0.01, 0.01], [0.02, 0.01, 0.01])]
    assert found.u[ends[0], 0] > 3e-4
    assert found.u[ends[1], 0] < -3e-4


def test_nested_cylinders_contract_along_their_axis_symmetrically():
    """Figure 7.7: the free top comes down; the model has the symmetry of a square about its axis."""
    anatomy = nested_cylinders()
    model = FullModel(anatomy)
    u = EquilibriumSolver(model, tolerance=1e-10).solve(np.array([1.0])).u
    points = anatomy.points
    top_centre = np.linalg.norm(points - [0.0, points[:, 1].max(), 0.0], axis=1).argmin()
    largest = np.abs(u).max()
    assert u[top_centre, 1] < -2e-3
    assert np.abs(u[top_centre, [0, 2]]).max() < 1e-6 * largest
    for image in (np.array([-1.0, 1.0, 1.0]), np.array([1.0, 1.0, -1.0])):
        np.testing.assert_allclose(u[partner(points, points * image)] * image, u, atol=1e-6 * largest)
    quarter = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    np.testing.assert_allclose(u[partner(points, points @ quarter.T)], u @ quarter.T, atol=1e-6 * largest)


def partner(points, images):
    distance = np.linalg.norm(points[None] - images[:, None], axis=2)
    assert distance.min(axis=1).max() < 1e-12
    return distance.argmin(axis=1)


def test_no_equilibrium_is_an_error_that_carries_the_report():
    model = FullModel(muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3)))
    with pytest.raises(NotConvergedError, match=r"pull = 1.*lower the activations") as caught:
        EquilibriumSolver(model, max_iterations=1).solve(np.array([1.0]))
    assert not caught.value.report.converged
    assert caught.value.report.rejected_steps > 0


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_parameter_that_is_not_a_number_is_named(value):
    model = FullModel(muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3)))
    with pytest.raises(InputError, match=r"parameter pull is -?(nan|inf); give a finite number"):
        EquilibriumSolver(model).solve(np.array([value]))


def test_parameters_of_another_length_are_refused():
    model = FullModel(muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3)))
    with pytest.raises(InputError, match=r"parameters have shape \(3,\); give 1: pull"):
        EquilibriumSolver(model).solve(np.ones(3))


def test_an_equilibrium_keeps_its_parameters_when_the_caller_changes_the_array():
    model = FullModel(muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3)))
    parameters = np.array([0.5])
    found = EquilibriumSolver(model).solve(parameters)
    parameters[0] = 1.0
    assert found.parameters[0] == 0.5


def test_a_start_that_is_not_admissible_is_refused():
    model = FullModel(muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3)))
    for start in (np.full_like(model.anatomy.points, np.nan), -1.5 * model.anatomy.points):
        with pytest.raises(NotConvergedError, match=r"no equilibrium beyond 0\.0 %"):
            EquilibriumSolver(model).solve(np.array([1.0]), Equilibrium(np.zeros(1), start))


def test_solution_does_not_depend_on_the_start():
    model = FullModel(muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3)))
    solver = EquilibriumSolver(model, tolerance=1e-11)
    half = solver.solve(np.array([0.5]))
    np.testing.assert_allclose(solver.solve(np.array([1.0]), half).u, solver.solve(np.array([1.0])).u, atol=1e-10)


def test_a_guess_that_is_not_admissible_is_mended():
    model = FullModel(muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3)))
    solver, parameters = EquilibriumSolver(model, tolerance=1e-11), np.array([1.0])
    exact = solver.solve(parameters).u
    for share in (0.9, 3.0):
        assert np.isfinite(model.energy(share * exact)) == (share < 1.0)
        np.testing.assert_allclose(solver.settle(parameters, share * exact).u, exact, atol=1e-10)


def test_a_guess_has_the_bones_where_the_parameters_have_them():
    solver = EquilibriumSolver(FullModel(dragged_block("hexahedron", Yeoh.neo_hookean(15e3, 0.45), cells=(6, 6, 2))))
    exact = solver.solve(0.5 * SIDEWAYS).u
    np.testing.assert_allclose(solver.settle(0.5 * SIDEWAYS, 1.1 * exact).u, exact, atol=1e-5 * np.abs(exact).max())


def test_a_guess_beside_which_nothing_is_admissible_is_refused():
    model = FullModel(muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3)))
    with pytest.raises(NotConvergedError, match="no equilibrium beside a guess at"):
        EquilibriumSolver(model).settle(np.array([1.0]), np.full_like(model.anatomy.points, np.nan))


def test_a_load_step_begins_with_the_factors_of_the_equilibrium_before():
    solver = EquilibriumSolver(FullModel(dragged_block("hexahedron", Yeoh.neo_hookean(15e3, 0.45), cells=(6, 6, 2))))
    before = solver.solve(0.5 * SIDEWAYS)
    followed = solver.solve(0.55 * SIDEWAYS, before)
    anew = solver.solve(0.55 * SIDEWAYS, replace(before))
    assert followed.report.factorisations < anew.report.factorisations
    np.testing.assert_allclose(followed.u, anew.u, atol=1e-5 * np.abs(anew.u).max())


def test_where_rough_factors_fail_exact_ones_find_the_equilibrium():
    class NeverRough(FullModel):
        def factorise(self, values, blocks, *, rough=False):
            if rough:
                raise NotPositiveDefiniteError("rounding")
            super().factorise(values, blocks)

    anatomy = dragged_block("hexahedron", Yeoh.neo_hookean(15e3, 0.45), cells=(6, 6, 2))
    usual, exact = (EquilibriumSolver(kind(anatomy)).solve(SIDEWAYS) for kind in (FullModel, NeverRough))
    assert exact.report.rejected_steps > 0 == usual.report.rejected_steps
    np.testing.assert_allclose(exact.u, usual.u, atol=1e-5 * np.abs(usual.u).max())


@pytest.mark.parametrize("name", sorted(SOLVERS))
def test_linear_solver_solves_and_refuses_indefinite_matrices(name):
    if name == "pardiso":
        pytest.importorskip("pypardiso")
    import scipy.sparse as sp

    rng = np.random.default_rng(0)
    half = sp.random(60, 60, 0.05, random_state=1)
    matrix = (half @ half.T + 0.1 * sp.eye(60)).tocsr()
    upper = sp.triu(matrix, format="csr")
    upper.sort_indices()
    solver = SOLVERS[name]()
    solver.analyse(sp.csr_matrix(sp.eye(60)))  # another pattern, to be let go
    solver.analyse(upper)
    right = rng.normal(size=(60, 3))
    for scale in (1.0, 2.0):
        solver.factorise(scale * upper.data)
        np.testing.assert_allclose(scale * matrix @ solver.solve(right), right, atol=1e-12 * np.abs(right).max() * 100)
        np.testing.assert_allclose(scale * matrix @ solver.solve(right[:, 0]), right[:, 0], atol=1e-10)
    with pytest.raises(NotPositiveDefiniteError):
        solver.factorise(-upper.data)


def test_epidermis_sees_a_folded_skin_triangle_that_no_quadrature_point_sees():
    points, cells = box("hexahedron", cells=(1, 1, 1))
    bare = block_anatomy(points, cells, Yeoh(2500.0, 1175.0, 250e3))
    corner = np.zeros_like(points)
    corner[-1, 2] = -0.031  # one corner of the 20 mm cube goes down through the bottom
    models = [FullModel(replace(bare, epidermis=thickness), walled=False) for thickness in (0.0, 1e-4)]
    for model in models:
        model.set_parameters(np.zeros(0))
    assert models[0].point_jacobians(corner).min() > 0
    assert np.isfinite(models[0].energy(corner))
    assert models[1].point_jacobians(corner).min() < 0
    assert models[1].energy(corner) == np.inf
