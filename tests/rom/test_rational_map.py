"""The learned map against targets whose answer is known, and against finite differences."""

import itertools
from dataclasses import replace

import h5py
import numpy as np
import pytest

from risorius.evaluators import PolynomialMap, RationalMap, rational
from risorius.evaluators.competition import _Fit, compete, compete_slopes, fit_competition
from risorius.evaluators.observations import Observations, Reflection
from risorius.evaluators.products import as_products, choose_terms, multiply, multiply_slopes, needed

MUSCLES, POSES, MODES = 4, 1, 3
COUNT = MUSCLES + POSES
REFLECTION = Reflection(np.array([1, 0, 3, 2, 4]), np.array([1.0, 1, 1, 1, -1]), np.array([1.0, -1, 1]))


def quadratic(p):
    a, b, c, d, pose = p
    return np.array([a + 0.3 * b * b, b + 0.2 * a * c + 0.1 * pose**4, d + 0.5 * pose * c * d])


def competing(p):
    total = p[:MUSCLES] / (1.0 + p[:MUSCLES].sum() * np.array([1.0, 0.8, 1.2, 0.5]))
    return total @ np.array([[1.0, 0.2, 0], [0, 1, 0], [0.3, 0, 1], [1, 1, 0]]) + p[MUSCLES] * np.array([0, 0, 0.5])


def slopes_of(answer, p, step=1e-5):
    return np.stack([(answer(p + e) - answer(p - e)) / (2 * step) for e in step * np.eye(len(p))])


def symmetric(p):
    """An answer that turns into its mirror image with the input, under REFLECTION."""
    image = p[REFLECTION.partner] * REFLECTION.sign
    return 0.5 * (competing(p) + REFLECTION.parity * competing(image))


def observed(answer, count, seed=0, reflection=None):
    rng = np.random.default_rng(seed)
    parameters = np.column_stack([rng.uniform(0, 1, (count, MUSCLES)), rng.uniform(-1, 1, (count, POSES))])
    return Observations(
        parameters=parameters,
        coordinates=np.array([answer(p) for p in parameters]),
        derivatives=np.array([slopes_of(answer, p) for p in parameters]).astype(np.float32),
        muscles=MUSCLES,
        lowest=np.array([0.0] * MUSCLES + [-1.0] * POSES),
        overlap=np.ones((COUNT, COUNT)),
        sizes=np.ones(COUNT),
        reflection=reflection,
    )


def answers(learned, parameters):
    result = np.empty((len(parameters), MODES))
    for p, out in zip(parameters, result, strict=True):
        learned.coordinates(p, out)
    return result


def worst_error(learned, answer):
    fresh = observed(answer, 200, seed=1)
    return np.abs(answers(learned, fresh.parameters) - fresh.coordinates).max()


def test_a_map_is_exact_at_rest():
    learned = RationalMap.fit(observed(competing, 30))
    np.testing.assert_array_equal(answers(learned, np.zeros((1, COUNT))), 0.0)


def test_no_admissible_input_comes_near_a_pole():
    """A pose that helps muscles, and cannot be negative."""

    def helped(p):
        return np.array([p[0] / (1.2 - p[4]), p[1] / (1.2 - p[4]), p[2] + p[3]])

    data = observed(helped, 60)
    data = replace(data, lowest=np.zeros(COUNT), parameters=np.abs(data.parameters) * [1, 1, 1, 1, 0.9])
    coordinates = np.array([helped(p) for p in data.parameters])
    derivatives = np.array([slopes_of(helped, p) for p in data.parameters]).astype(np.float32)
    weights = fit_competition(replace(data, coordinates=coordinates, derivatives=derivatives))
    assert weights[MUSCLES].min() < -0.3
    corners = np.array(list(itertools.product((0.0, 1.0), repeat=COUNT)))
    assert (1.0 + corners @ weights).min() >= 0.5


def test_a_polynomial_answer_is_found_to_a_thousandth():
    """Not exactly: the denominators are fitted first, and stay."""
    largest = np.abs(observed(quadratic, 200, seed=1).coordinates).max()
    assert worst_error(RationalMap.fit(observed(quadratic, 60)), quadratic) < 1e-3 * largest


def test_competing_muscles_are_followed_where_a_polynomial_cannot():
    data = observed(competing, 60)
    polynomial = PolynomialMap.fit(data.parameters, data.coordinates, data.overlap)
    assert worst_error(RationalMap.fit(data), competing) < 0.1 * worst_error(polynomial, competing)


def test_derivatives_stand_for_snapshots_that_are_not_there():
    few = observed(competing, 12)
    values_only = RationalMap.fit(replace(few, derivatives=None))
    assert worst_error(RationalMap.fit(few), competing) < 0.1 * worst_error(values_only, competing)


def test_the_map_of_a_symmetric_face_is_symmetric():
    learned = RationalMap.fit(observed(symmetric, 40, reflection=REFLECTION))
    parameters = observed(symmetric, 20, seed=2).parameters
    mirrored = answers(learned, parameters[:, REFLECTION.partner] * REFLECTION.sign)
    np.testing.assert_allclose(mirrored, answers(learned, parameters) * REFLECTION.parity, atol=1e-6)
    assert worst_error(learned, symmetric) < 0.01


def test_symmetry_stands_for_snapshots_that_are_not_there():
    one_sided = observed(symmetric, 12)
    both = RationalMap.fit(replace(one_sided, reflection=REFLECTION))
    assert worst_error(both, symmetric) < 0.5 * worst_error(RationalMap.fit(one_sided), symmetric)


def test_a_stored_map_answers_as_before(tmp_path):
    learned = RationalMap.fit(observed(symmetric, 20, reflection=REFLECTION))
    with h5py.File(tmp_path / "map.h5", "w") as file:
        learned.write(file.create_group("map"))
        stored = RationalMap.read(file["map"])
    parameters = observed(symmetric, 10, seed=3).parameters
    np.testing.assert_array_equal(answers(stored, parameters), answers(learned, parameters))


def test_gradient_of_the_competition_fit_is_that_of_its_loss():
    problem = _Fit(observed(competing, 8), MODES)
    weights = np.random.default_rng(4).uniform(0.1, 1.0, (COUNT, COUNT))
    direction = np.random.default_rng(5).normal(size=weights.shape)
    plus, minus = (problem.loss(weights + step * direction)[0] for step in (1e-6, -1e-6))
    assert np.vdot(problem.loss(weights)[1], direction) == pytest.approx((plus - minus) / 2e-6, rel=1e-5)


def test_derivatives_of_the_terms_are_those_of_their_values():
    data = observed(competing, 1)
    products = as_products(list(choose_terms(data)))
    weights = np.random.default_rng(6).uniform(0.0, 1.0, (COUNT, COUNT))

    def terms(p):
        variables, values = np.empty(COUNT), np.empty(len(products.parents))
        compete(p, weights, variables)
        multiply(variables, products.parents, products.factors, values)
        return values

    variables, slopes = np.empty(COUNT), np.empty((COUNT, COUNT))
    values, gradients = np.empty(len(products.parents)), np.empty((len(products.parents), COUNT))
    compete_slopes(data.parameters[0], weights, variables, slopes)
    multiply_slopes(variables, slopes, products.parents, products.factors, values, gradients)
    np.testing.assert_allclose(values, terms(data.parameters[0]), rtol=1e-12)
    np.testing.assert_allclose(gradients.T, slopes_of(terms, data.parameters[0]), atol=1e-9)


def test_terms_that_are_needed_are_kept_with_what_they_are_made_of():
    variables = np.array([2.0, 3.0, 5.0])
    products = as_products([(0,), (1,), (2,), (1, 1), (1, 2), (1, 1, 1), (1, 1, 2)])
    fewer, numbers = needed(products, np.array([[6, 2]], np.int32))
    values = np.empty(len(fewer.parents))
    multiply(variables, fewer.parents, fewer.factors, values)
    np.testing.assert_array_equal(values[numbers], [[45.0, 5.0]])
    assert len(values) == 4  # 1, 2, 11, 112


def test_a_pruned_map_keeps_the_features_that_tell(monkeypatch):
    data = observed(quadratic, 60)
    monkeypatch.setattr(rational, "MOST_COEFFICIENTS", 20 * MODES)
    pruned = RationalMap.fit(data)
    assert pruned.blocks[0].coefficients.shape == (20, MODES)
    assert len(choose_terms(data)) > 50
    assert worst_error(pruned, quadratic) < 0.02 * np.abs(data.coordinates).max()
