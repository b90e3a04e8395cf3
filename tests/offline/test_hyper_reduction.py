"""The reduced body against the full model: with all modes and elements it is the same, and few elements approach it."""

from dataclasses import dataclass

import h5py
import numpy as np
import pytest

from risorius.effort import Effort
from risorius.evaluators import CorrectedMap
from risorius.hyper_reduction.correction import Correction
from risorius.hyper_reduction.cubature import choose, element_forces
from risorius.hyper_reduction.lanes import FLOOR, relaxed_log, relaxed_log_slopes
from risorius.hyper_reduction.muscles import ReducedMuscles
from risorius.hyper_reduction.reduced_body import ReducedBody
from risorius.hyper_reduction.sampled_body import Equilibria, SampledBody, sample_body
from risorius.hyper_reduction.tissue import Tissue
from risorius.hyper_reduction.wall import Walls, relaxed_barrier
from risorius.mechanics.material import Yeoh
from risorius.mechanics.wall import barrier
from risorius.part import Part
from risorius.poses import Poses
from risorius_offline.body import body_of
from risorius_offline.equilibrium import Equilibrium, EquilibriumSolver
from risorius_offline.full_model import FullModel
from risorius_offline.quantities import muscle_state
from tests.offline.models import muscle_block

SOFT = Yeoh.neo_hookean(15e3, 0.45)
KINDS = ("hexahedron", "wedge", "tetra10")


@pytest.fixture(scope="module", params=KINDS)
def model(request):
    return FullModel(muscle_block(request.param, Yeoh(SOFT.c10, 0.3 * SOFT.c10, SOFT.bulk)))


@pytest.fixture(scope="module")
def whole(model):
    """All elements, and every free component of the displacement a coordinate."""
    fields = np.zeros((len(model.free), model.discretisation.dof_count))
    fields[np.arange(len(model.free)), model.free] = 1.0
    return reduced(model, fields.reshape(len(fields), -1, 3))


def terms_of(model):
    body = body_of(model)
    return [Tissue(table) for table in body.passive] + [Walls(table) for table in body.walls]


def reduced(model, fields):
    muscles = ReducedMuscles.of(body_of(model), model.anatomy.points, fields)
    return ReducedBody(terms_of(model), fields, 0, muscles)


def squeezed(model, seed=0, size=2e-3):
    """A displacement of the free nodes that is admissible and has walls act."""
    rng, u = np.random.default_rng(seed), np.zeros(model.discretisation.dof_count)
    u[model.free] = rng.normal(size=len(model.free))
    u *= size / np.abs(u).max()
    u = u.reshape(-1, 3) - [0.0, 0.0, 0.5] * model.anatomy.points
    u.reshape(-1)[model.prescribed] = 0.0
    while not np.isfinite(model.energy(u)) or model.point_jacobians(u).min() < 0.4:
        u *= 0.9
    return u


def test_energy_and_forces_are_those_of_the_full_model(model, whole):
    u, activation = squeezed(model), np.array([0.7])
    model.set_parameters(activation)
    whole.set_activations(activation)
    gradient, energies = np.empty(whole.rank), []
    for scale in (1.0, 0.3):
        whole.deform(scale * u.reshape(-1)[model.free])
        energies.append(whole.energy())
    assert energies[0] - energies[1] == pytest.approx(model.energy(u) - model.energy(0.3 * u), rel=1e-10)
    whole.deform(u.reshape(-1)[model.free])
    whole.gradient(gradient)
    forces = model.forces(u)[2].reshape(-1)[model.free]
    assert sum(wall.energy(u) for wall in model.walls) > 0.0
    assert np.abs(gradient - forces).max() < 1e-12 * np.abs(forces).max()


def test_all_modes_and_elements_give_the_full_equilibrium(model, whole):
    activation = np.array([1.0])
    truth = EquilibriumSolver(model, tolerance=1e-9).solve(activation).u
    whole.set_activations(activation)
    q, gradient = np.zeros(whole.rank), np.empty(whole.rank)
    for _ in range(30):
        whole.deform(q)
        whole.gradient(gradient)
        q -= np.linalg.solve(whole.stiffness(), gradient)
    assert np.abs(q - truth.reshape(-1)[model.free]).max() < 1e-6 * np.abs(truth).max()


def test_stiffness_is_symmetric_and_the_derivative_of_the_gradient(model, whole):
    rng = np.random.default_rng(1)
    q = squeezed(model).reshape(-1)[model.free]
    direction, h = rng.normal(size=whole.rank), 1e-9
    image, product = np.empty_like(whole.u), np.empty(whole.rank)
    whole.set_activations(np.array([0.5]))
    whole.deform(q)
    whole.image(direction, image)
    whole.product(direction, image, product)
    columns = np.array([whole_product(whole, one) for one in np.eye(whole.rank)])
    assert np.abs(columns - columns.T).max() < 1e-12 * np.abs(columns).max()
    ends = []
    for sign in (1.0, -1.0):
        whole.deform(q + sign * h * direction)
        ends.append(np.empty(whole.rank))
        whole.gradient(ends[-1])
    assert np.abs((ends[0] - ends[1]) / (2 * h) - product).max() < 1e-6 * np.abs(product).max()


def whole_product(body, direction):
    image, product = np.empty_like(body.u), np.empty(body.rank)
    body.image(direction, image)
    body.product(direction, image, product)
    return product


def test_a_move_along_an_image_is_a_deformation(model, whole):
    q = squeezed(model).reshape(-1)[model.free]
    direction = np.random.default_rng(2).normal(size=whole.rank) * 1e-4
    image = np.empty_like(whole.u)
    whole.deform(q)
    whole.image(direction, image)
    whole.move(0.5, direction, image)
    moved = whole.energy()
    whole.deform(q + 0.5 * direction)
    assert moved == pytest.approx(whole.energy(), rel=1e-12)


def test_inverted_elements_have_energy_forces_and_stiffness(model, whole):
    whole.set_activations(np.array([1.0]))
    for size in (0.05, 10.0):
        whole.deform(size * np.random.default_rng(3).normal(size=whole.rank))
        gradient = np.empty(whole.rank)
        whole.gradient(gradient)
        assert whole.smallest_jacobian() < 0.0
        assert np.isfinite(whole.energy())
        assert np.isfinite(gradient).all()
        assert np.isfinite(whole_product(whole, gradient)).all()


def test_the_relaxed_functions_are_smooth_where_they_begin_and_true_above():
    below, above = FLOOR * (1 - 1e-9), FLOOR * (1 + 1e-9)
    assert relaxed_log(below) == pytest.approx(relaxed_log(above), abs=1e-8)
    assert relaxed_log_slopes(below) == pytest.approx(relaxed_log_slopes(above), rel=1e-8)
    assert relaxed_barrier(below) == pytest.approx(relaxed_barrier(above), rel=1e-6)
    assert relaxed_log(0.7) == np.log(0.7)
    assert relaxed_barrier(0.7) == pytest.approx(barrier(0.7), rel=1e-14)
    assert relaxed_barrier(-3.0)[0] > relaxed_barrier(0.0)[0] > relaxed_barrier(FLOOR)[0]


def pod_of(states, rank):
    flat = states.reshape(len(states), -1)
    return np.linalg.svd(flat, full_matrices=False)[2][:rank].reshape(rank, -1, 3)


@pytest.fixture(scope="module")
def pulled():
    """A finer block, its equilibria under a growing pull, and modes of these."""
    model = FullModel(muscle_block("hexahedron", SOFT, cells=(4, 4, 4)))
    solver, weights = EquilibriumSolver(model), np.linspace(0.1, 1.0, 8)
    states = np.array([solver.solve(np.array([weight])).u for weight in weights])
    return model, weights, states, pod_of(states, 4) * 1e-3


def test_few_weighted_elements_give_the_training_forces(pulled):
    model, _, states, modes = pulled
    terms = terms_of(model)
    columns = np.concatenate([element_forces(terms, u, modes) for u in states], axis=1).astype(np.float32)
    sizes = [len(term.connectivity) for term in terms]
    cubature = choose(columns, sizes, sum(sizes), 1e-3)
    chosen = np.concatenate([part + start for part, start in zip(cubature.elements, [0, *sizes], strict=False)])
    total = columns.sum(axis=0)
    error = np.linalg.norm(np.concatenate(cubature.weights) @ columns[chosen] - total) / np.linalg.norm(total)
    assert error <= 1.01e-3
    assert cubature.missed == pytest.approx(error, rel=0.05)
    assert all((part > 0.0).all() for part in cubature.weights)
    assert cubature.size <= columns.shape[1] < sum(sizes)  # a solution of as many equations needs no more elements


def test_a_count_of_elements_is_kept(pulled):
    model, _, states, modes = pulled
    terms = terms_of(model)
    columns = np.concatenate([element_forces(terms, u, modes) for u in states], axis=1).astype(np.float32)
    assert choose(columns, [len(term.connectivity) for term in terms], 5, 0.0).size == 5


def test_correction_never_raises_the_energy(pulled):
    body = reduced(pulled[0], pulled[3])
    body.set_activations(np.array([0.8]))
    body.deform(np.zeros(body.rank))
    correction = Correction(body, body.stiffness())
    for start in np.random.default_rng(4).normal(size=(20, body.rank)) * 3.0:
        correction.residual(start)
        before = body.energy()
        correction.improve(1)
        assert body.energy() <= before


def test_correction_ends_at_the_minimum_of_the_energy(pulled):
    _, weights, states, modes = pulled
    body = reduced(pulled[0], modes)
    body.set_activations(weights[-1:])
    body.deform(np.zeros(body.rank))
    correction = Correction(body, body.stiffness())
    correction.residual(np.zeros(body.rank))
    correction.improve(15)
    gram = modes.reshape(len(modes), -1)
    truth = np.linalg.solve(gram @ gram.T, gram @ states[-1].ravel())
    gradient = np.empty(body.rank)
    body.gradient(gradient)
    assert np.linalg.norm(gradient) < 1e-6 * abs(body.energy())
    assert np.linalg.norm(body.q - truth) < 0.01 * np.linalg.norm(truth)


@dataclass(frozen=True)
class Guess:
    """A learned map that always gives the same coordinates."""

    answer: np.ndarray

    def coordinates(self, parameters, out):
        out[:] = self.answer

    def within(self, part):
        return Guess(self.answer[part.modes])


@pytest.fixture(scope="module")
def sampled(pulled):
    model, weights, states, modes = pulled
    gram = modes.reshape(len(modes), -1)
    coordinates = np.linalg.solve(gram @ gram.T, gram @ states.reshape(len(states), -1).T).T
    equilibria = Equilibria(weights[:, None], coordinates)
    return sample_body(body_of(model), model.anatomy.points, modes, 0, equilibria, 24), coordinates[-1]


def test_sampled_body_follows_the_full_equilibrium(pulled, sampled):
    model, _, _, modes = pulled
    body, _ = sampled
    assert body.size <= 24
    correction = body.correction()
    correction.body.set_activations(np.array([0.63]))
    correction.residual(np.zeros(len(modes)))
    correction.improve(20)
    truth = EquilibriumSolver(model).solve(np.array([0.63])).u
    found = np.tensordot(correction.body.q.astype(float), modes, axes=1)
    assert np.linalg.norm(found - truth) < 0.01 * np.linalg.norm(truth)


def test_a_body_whose_walls_no_state_feels_is_sampled_without_them(pulled):
    model, _, _, modes = pulled
    resting = Equilibria(np.zeros((1, 1)), np.zeros((1, len(modes))))
    assert sample_body(body_of(model), model.anatomy.points, modes, 0, resting, 24).walls == ()


def test_a_good_guess_stays_and_a_bad_one_is_corrected(sampled):
    body, truth = sampled
    out, full = np.empty(len(truth)), np.array([1.0])
    good = CorrectedMap(Guess(truth), body, Poses())
    good.coordinates(full, out)
    assert (out == truth).all()
    assert good.doubt <= body.quiet
    off = truth + 20 * body.quiet
    bad = CorrectedMap(Guess(off), body, Poses())
    bad.coordinates(full, out)
    assert bad.doubt > body.quiet
    assert np.linalg.norm(out - truth) < 0.2 * np.linalg.norm(off - truth)


def test_a_part_of_the_modes_is_corrected_as_in_the_whole(sampled):
    body, truth = sampled
    nothing, asked = np.zeros(0, np.int64), np.array([0, 2])
    part = Part(np.array([0]), np.array([True]), nothing, asked, nothing, nothing, lift_count=0)
    whole = CorrectedMap(Guess(truth + 20 * body.quiet), body, Poses())
    every, some = np.empty(len(truth)), np.empty(2)
    whole.coordinates(np.array([1.0]), every)
    whole.within(part).coordinates(np.array([1.0]), some)
    np.testing.assert_array_equal(some, every[asked])


def test_work_of_the_muscles_is_that_of_the_full_model(pulled, sampled):
    model, _, _, modes = pulled
    body, truth = sampled
    u = np.tensordot(truth, modes, axes=1)
    expected = muscle_state(model, Equilibrium(np.array([0.63]), u)).works
    assert expected[0] > 0.0
    assert Effort(body.muscles).of(np.array([0.63]), truth) == pytest.approx(expected, rel=1e-5)


def test_a_sampled_body_comes_back_from_its_file(sampled, tmp_path):
    body, truth = sampled
    with h5py.File(tmp_path / "body.h5", "w") as file:
        body.write(file)
    with h5py.File(tmp_path / "body.h5") as file:
        back = SampledBody.read(file)
    first, second = body.correction(), back.correction()
    for correction in (first, second):
        correction.body.set_activations(np.array([0.5]))
    assert first.residual(truth) == second.residual(truth)
    assert (back.size, back.quiet) == (body.size, body.quiet)


def test_leading_modes_are_those_of_the_whole(sampled):
    body, truth = sampled
    part = body.leading(2).correction()
    whole = body.correction()
    gradients = []
    for correction, q in ((part, truth[:2]), (whole, np.append(truth[:2], np.zeros(len(truth) - 2)))):
        correction.body.set_activations(np.array([0.5]))
        correction.body.deform(q)
        gradients.append(np.empty(correction.body.rank, np.float32))
        correction.body.gradient(gradients[-1])
    assert gradients[0] == pytest.approx(gradients[1][:2], rel=1e-5)
