"""The network map: its gradient against differences, its symmetry, and contact, which products cannot follow."""

import math
from dataclasses import replace

import h5py
import numpy as np
import pytest
from tests.rom.test_kinks import pressed
from tests.rom.test_rational_map import (
    COUNT,
    MODES,
    MUSCLES,
    REFLECTION,
    answers,
    competing,
    observed,
    symmetric,
    worst_error,
)

from risorius.errors import InputError
from risorius.evaluators import RationalMap, Setting, network
from risorius.evaluators.network_fit import fit_network
from risorius.evaluators.network_gradient import DECAY, DERIVATIVE_WEIGHT, NEURONS_EACH, NetworkGradient, views
from risorius.evaluators.remainder import RIDGE, WIDTH
from risorius.paired_sums import LARGEST_INPUT
from risorius.part import Part


@pytest.fixture(scope="module")
def learned():
    return fit_network(observed(symmetric, 40, reflection=REFLECTION))


@pytest.fixture(scope="module")
def usual():
    """Inputs of one parameter each, four widths from each other."""
    single = np.eye(COUNT)
    coordinates = np.array([symmetric(p) for p in single])
    return replace(observed(symmetric, COUNT), parameters=single, coordinates=coordinates, reflection=REFLECTION)


@pytest.fixture(scope="module")
def completed(learned, usual):
    return learned.completed(usual)


def one_part(parameters, modes):
    some = np.zeros(0, np.int64)
    return Part(np.array(parameters), np.ones(len(parameters), bool), some, np.array(modes), some, some, 0)


def test_gradient_of_the_fit_is_that_of_its_loss():
    problem, rng = NetworkGradient(observed(symmetric, 12), REFLECTION), np.random.default_rng(0)
    shapes = problem.shapes
    weights = 0.3 * rng.normal(size=sum(math.prod(shape) for shape in shapes.values())).astype(np.float32)
    views(weights, shapes)["competition"][:] = rng.uniform(0, 1, (COUNT, COUNT))
    gradient, unused = np.empty_like(weights), np.empty_like(weights)
    rows, directions = problem.draw(rng)
    problem.at(views(weights, shapes), rows, directions, views(gradient, shapes))
    for name in shapes:
        direction = np.zeros_like(weights)
        views(direction, shapes)[name][:] = rng.normal(size=shapes[name])
        plus, minus = (
            problem.at(views(weights + step * direction, shapes), rows, directions, views(unused, shapes))
            for step in (np.float32(3e-4), np.float32(-3e-4))
        )
        assert np.vdot(gradient, direction) == pytest.approx((plus - minus) / 6e-4, rel=5e-3), name


def test_coefficients_from_normal_equations_have_least_loss():
    problem, rng = NetworkGradient(observed(symmetric, 12), REFLECTION), np.random.default_rng(0)
    shapes = problem.shapes
    size = sum(math.prod(shape) for shape in shapes.values())
    weights, slopes = (
        views(0.3 * rng.normal(size=size).astype(np.float32), shapes),
        views(np.empty(size, np.float32), shapes),
    )
    weights["competition"][:] = rng.uniform(0, 1, (COUNT, COUNT))
    batch = problem.draw(rng)
    problem.at(weights, *batch, slopes)
    before = {name: np.abs(slopes[name]).max() for name in ("even", "odd")}
    for name, (matrix, right) in problem.normal_equations(weights, *batch).items():
        weights[name][:] = np.linalg.solve(matrix + DECAY * np.eye(len(matrix)), right)
    problem.at(weights, *batch, slopes)
    for name, slope in before.items():
        assert np.abs(slopes[name]).max() < 1e-3 * slope


def finer(p):
    """The answer of another mesh: stiffer, less so where it moves far."""
    return symmetric(0.9 * p) + 0.1 * symmetric(p) * np.abs(symmetric(p))


def test_what_a_coarser_mesh_has_taught_stands_for_snapshots_that_are_not_there():
    few = observed(finer, 12, reflection=REFLECTION)
    coarse = fit_network(observed(symmetric, 200, reflection=REFLECTION))
    assert worst_error(fit_network(few, coarse), finer) < 0.5 * worst_error(fit_network(few), finer)


def test_a_face_with_a_mirror_image_teaches_none_without(learned):
    with pytest.raises(InputError, match="one face is its own mirror image and the other is not"):
        fit_network(observed(symmetric, 12), learned)


def by_definition(member, parameters):
    """Of one input, in double precision; see the module's docstring."""
    partner, sign, parity = REFLECTION.partner, REFLECTION.sign, REFLECTION.parity
    b = parameters / (1.0 + parameters @ member.competition)

    def parts(ours, image):
        return ours + image, ours - image

    def bent(even, odd, thresholds):
        both = (bend(z / 2 + thresholds) - bend(thresholds.astype(float)) for z in parts(even, odd))
        return parts(*both)

    b = parts(b, sign * b[partner])
    h = bent(*(part @ member.first.values for part in b), member.first_thresholds)
    inputs = [np.concatenate(both) for both in zip(b, h, strict=True)]
    k = bent(inputs[0] @ member.second_even.values, inputs[1] @ member.second_odd.values, member.second_thresholds)
    features = [np.concatenate(both) for both in zip(inputs, k, strict=True)]
    answer = np.empty(MODES)
    answer[parity > 0.0], answer[parity < 0.0] = features[0] @ member.even.values, features[1] @ member.odd.values
    return answer


def bend(z):
    return np.sqrt(z**2 + network.WIDTH**2) - network.WIDTH


def test_it_answers_as_it_is_defined(learned):
    """But that inputs of sums are whole numbers up to LARGEST_INPUT, so off by half of one at most."""
    own_image = [0.7, 0.7, 0.3, 0.3, 0.0]  # of which one side is computed
    parameters = np.vstack([observed(symmetric, 20, seed=4).parameters, own_image])
    expected = [np.mean([by_definition(one, p) for one in learned.members], axis=0) for p in parameters]
    np.testing.assert_allclose(answers(learned, parameters), expected, atol=np.abs(expected).max() / LARGEST_INPUT)


def test_derivatives_in_random_directions_cost_on_average_what_those_by_all_parameters_do():
    data = observed(symmetric, 8)
    nothing = replace(data, coordinates=np.zeros_like(data.coordinates))  # of which weights of 0 miss no value
    problem, rng = NetworkGradient(nothing, REFLECTION), np.random.default_rng(0)
    size = sum(math.prod(shape) for shape in problem.shapes.values())
    weights, unused = (views(np.zeros(size, np.float32), problem.shapes) for _ in range(2))
    rows = np.arange(8)
    losses = [problem.at(weights, rows, problem.draw(rng)[1], unused) for _ in range(400)]
    expected = DERIVATIVE_WEIGHT**2 * (data.derivatives**2).sum(axis=(1, 2)).mean()
    assert np.mean(losses) == pytest.approx(expected, rel=0.05)


def test_it_is_exact_at_rest(learned):
    np.testing.assert_array_equal(answers(learned, np.zeros((1, COUNT))), 0.0)


def test_on_a_symmetric_face_it_is_symmetric(learned):
    parameters = observed(symmetric, 20, seed=2).parameters
    mirrored = answers(learned, parameters[:, REFLECTION.partner] * REFLECTION.sign)
    np.testing.assert_allclose(mirrored, answers(learned, parameters) * REFLECTION.parity, atol=1e-6)


def test_an_input_that_is_its_own_image_moves_no_other_mode(learned):
    symmetric_input = np.array([0.7, 0.7, 0.3, 0.3, 0.0])
    found = answers(learned, symmetric_input[None])[0]
    beside = answers(learned, symmetric_input[None] + [0, 0, 0, 0, 1e-7])[0]
    np.testing.assert_array_equal(found[REFLECTION.parity < 0], 0.0)
    np.testing.assert_allclose(found, beside, atol=1e-5)  # both sides computed, not one


def test_denominators_stay_admissible(learned):
    for member in learned.members:
        assert member.competition[:MUSCLES].min() >= 0.0
        np.testing.assert_array_equal(member.competition[:, MUSCLES:], 0.0)


def test_lips_that_press_on_each_other_are_followed_where_products_cannot(monkeypatch):
    data = observed(pressed, 60)
    found = worst_error(fit_network(data), pressed)
    monkeypatch.setattr("risorius.evaluators.rational.fit_kinks", lambda data, competition: np.zeros((COUNT, 0)))
    assert found < 0.7 * worst_error(RationalMap.fit(data), pressed)


def test_members_agree_where_they_know(learned):
    """The root mean square of their distance to their mean, and larger beyond what they have seen."""
    parameters = observed(symmetric, 1, seed=5).parameters
    mean = answers(learned, parameters)[0]
    alone = [answers(replace_members(learned, member), parameters)[0] for member in learned.members]
    answers(learned, parameters)
    expected = np.sqrt(np.mean([((one - mean) ** 2).sum() for one in alone]))
    assert learned.doubt == pytest.approx(expected, rel=1e-4)
    inputs = observed(symmetric, 40, seed=6).parameters
    assert np.median(doubts(learned, 3.0 * inputs)) > 1.5 * np.median(doubts(learned, inputs))


def doubts(learned, parameters):
    found = []
    for one in parameters:
        answers(learned, one[None])
        found.append(learned.doubt)
    return found


def replace_members(learned, member):
    return replace(learned, members=(member,))


def test_what_it_misses_at_usual_inputs_is_added_there_and_nowhere_else(learned, completed, usual):
    """All but RIDGE / (1 + RIDGE) of it at centres that do not see each other; two widths off a seventh is added."""
    missed = answers(learned, usual.parameters) - usual.coordinates
    left = answers(completed, usual.parameters) - usual.coordinates
    assert np.abs(missed).max() > 1e-3
    np.testing.assert_allclose(left, missed * RIDGE / (1.0 + RIDGE), atol=0.03 * np.abs(missed).max())
    beside = usual.parameters * (1.0 + 2.0 * WIDTH)
    added = answers(completed, beside) - answers(learned, beside)
    np.testing.assert_allclose(added, -np.exp(-2.0) * missed, atol=0.03 * np.abs(missed).max())
    far = 2.0 * np.ones((1, COUNT))
    np.testing.assert_array_equal(answers(completed, far), answers(learned, far))


def test_what_is_added_is_nothing_at_rest_and_symmetric(completed):
    test_it_is_exact_at_rest(completed)
    np.testing.assert_allclose(answers(completed, np.full((1, COUNT), 1e-6)), 0.0, atol=1e-5)
    test_on_a_symmetric_face_it_is_symmetric(completed)


@pytest.mark.parametrize("kind", ["learned", "completed"])
@pytest.mark.parametrize(("left", "kept"), [([0, 2, 4], 5), ([1], 2), ([4], 1), ([0, 1], 2)])
def test_a_part_answers_as_the_whole_does(kind, left, kept, request):
    """Of other parameters only mirror images are left, which would add nothing but zeros to any sum."""
    learned = request.getfixturevalue(kind)
    parameters = np.zeros(COUNT)
    parameters[left] = observed(symmetric, 1, seed=6).parameters[0, left]
    whole, part = answers(learned, parameters[None])[0], np.empty(2)
    few = learned.within(one_part(left, [0, 2]))
    few.coordinates(parameters[left], part)
    np.testing.assert_array_equal(part, whole[[0, 2]])
    assert few.members[0].first.numbers.shape == (kept, NEURONS_EACH * COUNT)


@pytest.mark.parametrize("kind", ["learned", "completed"])
def test_leading_modes_are_those_of_the_whole(kind, request):
    learned = request.getfixturevalue(kind)
    parameters = observed(symmetric, 1, seed=7).parameters[0]
    leading = np.empty(2)
    learned.at(Setting("network", 2)).coordinates(parameters, leading)
    np.testing.assert_allclose(leading, answers(learned, parameters[None])[0][:2], atol=1e-6)


@pytest.mark.parametrize("kind", ["learned", "completed"])
def test_a_stored_network_answers_as_before(tmp_path, kind, request):
    learned = request.getfixturevalue(kind)
    with h5py.File(tmp_path / "map.h5", "w") as file:
        learned.write(file.create_group("map"))
        stored = type(learned).read(file["map"])
    parameters = observed(symmetric, 10, seed=3).parameters
    np.testing.assert_array_equal(answers(stored, parameters), answers(learned, parameters))


def test_a_face_without_mirror_image_is_learned_too():
    found = fit_network(observed(competing, 60))
    assert worst_error(found, competing) < 0.05 * np.abs(observed(competing, 200, seed=1).coordinates).max()
    assert found.members[0].odd.numbers.shape == (COUNT + 2 * NEURONS_EACH * COUNT, 0)
    assert found.reflection.parity.shape == (MODES,)


def test_without_derivatives_it_is_refused():
    with pytest.raises(InputError, match="derivatives"):
        fit_network(replace(observed(competing, 5), derivatives=None))
