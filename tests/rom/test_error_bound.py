"""The bound of a frame's error, against errors whose law is known."""

import math
import tracemalloc

import numpy as np
import pytest

from risorius.error_bound import INDICATORS, SMALLEST, ErrorBound, indicate
from risorius.pipeline import pipelines

POWERS = np.array([0.5, 0.0, 1.0, 0.3])
SCALE, SPREAD = 1e-7, 0.4


def made_up(count, rng, spread=SPREAD):
    """Indicators (count, 4) and errors: a product of powers, times noise whose logarithm is normal."""
    indicators = np.exp(rng.normal(size=(count, 4)))
    errors = SCALE * np.prod((1.0 + indicators / SMALLEST) ** POWERS, axis=1) * np.exp(spread * rng.normal(size=count))
    return indicators, errors


def bounds(bound, indicators):
    return np.array([bound.value(tuple(row)) for row in indicators])


def test_new_frames_are_covered_and_not_by_far():
    """A normal law has 95 % below 1.64 deviations, so no bound that covers can be nearer than exp(1.64 spread)."""
    rng = np.random.default_rng(0)
    covered, ratio = [], []
    for _ in range(30):
        bound = ErrorBound.fit(*made_up(100, rng))
        indicators, errors = made_up(500, rng)
        found = bounds(bound, indicators)
        covered.append((errors <= found).mean())
        ratio.append(np.median(found / errors))
    assert np.mean(covered) > 0.95
    assert np.mean(ratio) < 1.2 * math.exp(1.64 * SPREAD)


def test_the_law_is_found():
    bound = ErrorBound.fit(*made_up(2000, np.random.default_rng(2), spread=1e-3))
    np.testing.assert_allclose(bound.exponents, POWERS, atol=1e-3)


def test_no_indicator_lowers_the_bound():
    """Not even where held-out snapshots happened to have smaller errors with more of one."""
    rng = np.random.default_rng(3)
    indicators = np.exp(rng.normal(size=(60, 4)))
    bound = ErrorBound.fit(indicators, 1e-3 / indicators[:, 0])
    assert min(bound.exponents) >= 0.0


@pytest.mark.parametrize("value", [0.0, 1e-300, 1.0, 1e300, math.inf, math.nan])
def test_a_bound_is_never_negative_nor_no_number(value):
    bound = ErrorBound(1e-6, (0.2, 1.0, 1.5, 0.3))
    for position in range(len(INDICATORS)):
        indicators = [1.0] * len(INDICATORS)
        indicators[position] = value
        assert bound.value(tuple(indicators)) >= 1e-6


@pytest.mark.parametrize("count", [1, 2, 7])
def test_few_snapshots_still_give_a_bound_that_covers_them(count):
    indicators, errors = made_up(count, np.random.default_rng(4))
    assert (bounds(ErrorBound.fit(indicators, errors), indicators) >= 0.999 * errors).all()


def test_exact_answers_have_a_bound():
    indicators, _ = made_up(20, np.random.default_rng(5))
    assert 0.0 < bounds(ErrorBound.fit(indicators, np.zeros(20)), indicators).max() < 1e-8


def test_indicators_are_what_they_are_called():
    parameters, modal = np.array([0.0, 0.3, -0.3]), np.array([1.0, 2.0, 3.0, 4.0])
    activity, interaction, tail = indicate(parameters, modal, np.array([1.0, 2.0, 0.0, 0.0]), 2)
    assert activity == pytest.approx(1.0)  # two parameters, each half active
    assert interaction == pytest.approx(5.0)
    assert tail == pytest.approx(5.0)


def test_what_an_evaluator_doubts_is_an_indicator(synthetic_model, monkeypatch):
    (point,) = synthetic_model.points[-1:]
    (way,) = pipelines(synthetic_model, [point.setting])
    monkeypatch.setattr(type(synthetic_model.evaluators["polynomial"]), "doubt", 0.25)
    assert way.solve(np.zeros(5)) == (0.0, 0.0, 0.0, 0.25)


def test_a_frame_allocates_nothing_big(synthetic_model):
    ways = pipelines(synthetic_model, [point.setting for point in synthetic_model.points])
    out, parameters = np.empty_like(synthetic_model.rest_vertices), np.full(5, 0.5)
    for way in ways:
        way.solve(parameters)
        way.write(out)
    tracemalloc.start()
    try:
        for way in ways:
            way.solve(parameters)
            way.write(out)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < out.nbytes // 2


def test_a_handful_of_frames_gives_a_constant():
    rng = np.random.default_rng(0)
    errors = rng.uniform(1e-4, 2e-4, 5)
    bound = ErrorBound.fit(rng.uniform(size=(5, 4)), errors)
    assert 1e-4 < bound.value((0.0,) * 4) == bound.value((1.0,) * 4) < 1e-3
