"""Kinks of the learned map: against finite differences, and where contact makes an answer one-sided."""

import numpy as np
import pytest
from tests.rom.test_rational_map import (
    COUNT,
    MODES,
    REFLECTION,
    answers,
    competing,
    observed,
    slopes_of,
    symmetric,
    worst_error,
)

from risorius.evaluators import RationalMap, kinks
from risorius.evaluators.kinks import KinkFit, bend, bend_slopes, fit_kinks

COMPETITION = 0.5 * np.eye(COUNT)


def pressed(p):
    """Two lips, pulled by a muscle each, that move together while they press on each other."""
    upper, lower = p[0] - 0.3 * p[2], p[1] - 0.3 * p[3]
    press = max(lower - upper, 0.0) / 2
    return np.array([upper + press, lower - press, p[4]])


def bent(p, weights):
    result = np.empty(weights.shape[1])
    bend(p, weights, result)
    return result


def test_a_kink_is_the_size_of_a_combination_with_a_rounded_corner():
    found = bent(np.array([0.3, 0.4]), np.array([[1.0, 1.0, 0.0], [0.0, -1.0, 0.0]]))
    width = kinks.WIDTH
    np.testing.assert_allclose(found, [np.hypot(0.3, width) - width, np.hypot(0.1, width) - width, 0.0], rtol=1e-12)


def test_derivatives_of_kinks_are_those_of_their_values():
    rng = np.random.default_rng(0)
    p, weights = rng.uniform(-1, 1, COUNT), rng.normal(size=(COUNT, 7))
    values, slopes = bend_slopes(p, np.eye(COUNT), weights)
    np.testing.assert_allclose(values, bent(p, weights), rtol=1e-12)
    np.testing.assert_allclose(slopes.T, slopes_of(lambda q: bent(q, weights), p), atol=1e-8)


def test_gradient_of_the_kink_fit_is_that_of_its_loss():
    problem = KinkFit.of(observed(competing, 30), COMPETITION)
    rng = np.random.default_rng(4)
    weights, direction = rng.normal(size=(2, COUNT, 6))
    plus, minus = (problem.loss(weights + step * direction)[0] for step in (1e-3, -1e-3))
    assert np.vdot(problem.loss(weights)[1], direction) == pytest.approx((plus - minus) / 2e-3, rel=1e-3)


def test_lips_that_press_on_each_other_are_followed_where_products_cannot(monkeypatch):
    data = observed(pressed, 60)
    kinked = worst_error(RationalMap.fit(data), pressed)
    monkeypatch.setattr("risorius.evaluators.rational.fit_kinks", lambda data, competition: np.zeros((COUNT, 0)))
    assert kinked < 0.5 * worst_error(RationalMap.fit(data), pressed)


def test_kinks_of_a_symmetric_face_come_with_their_mirror_images():
    data = observed(symmetric, 20, reflection=REFLECTION)
    weights = fit_kinks(data, COMPETITION)
    one, other = np.hsplit(weights, 2)
    p = np.random.default_rng(1).uniform(0, 1, COUNT)
    np.testing.assert_allclose(bent(p[REFLECTION.partner] * REFLECTION.sign, one), bent(p, other), rtol=1e-12)
    assert not np.allclose(one, other)


def test_a_map_of_values_alone_has_no_kinks():
    data = observed(competing, 20)
    values_only = RationalMap.fit(type(data)(**{**vars(data), "derivatives": None}))
    assert values_only.kinks.shape == (COUNT, 0)
    assert answers(values_only, data.parameters).shape == (20, MODES)
