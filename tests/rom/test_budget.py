"""What a budget buys: the table decides, never the clock of the machine that tests."""

import itertools
import logging
from dataclasses import replace

import numpy as np
import pytest
from tests.rom.test_rational_map import competing, observed

import risorius
from risorius import choosing
from risorius.budget import Budget, Choice, Offer, choose
from risorius.errors import InputError
from risorius.evaluators import PolynomialMap, RationalMap, Setting, Superposition
from risorius.operating_point import Seconds
from risorius.pipeline import pipelines
from risorius.timing import AT_WORK, MARGIN, cautious, frame_seconds, random_weights

QUICK, MIDDLE, EXACT = Offer(1e-5, 9e-3, 3e-3), Offer(1e-4, 2e-3, 6e-4), Offer(1e-3, 5e-4, 1e-4)
SLOW_AND_BAD = Offer(2e-3, 8e-3, 2e-3)
OFFERS = [SLOW_AND_BAD, EXACT, QUICK, MIDDLE]


@pytest.mark.parametrize(
    ("budget", "taken", "met"),
    [
        (Budget(time=5e-3), EXACT, True),
        (Budget(time=5e-4), MIDDLE, True),
        (Budget(time=2e-5), QUICK, True),
        (Budget(time=1e-6), QUICK, False),
        (Budget(error=1e-2), QUICK, True),
        (Budget(error=8.5e-3), MIDDLE, True),
        (Budget(error=5e-4), EXACT, True),
        (Budget(error=1e-4), EXACT, False),
        (Budget(time=5e-4, error=5e-3), MIDDLE, True),
        (Budget(time=5e-4, error=1e-3), MIDDLE, False),
        (Budget(time=1e-6, error=1e-3), QUICK, False),
    ],
    ids=str,
)
def test_the_fastest_that_is_good_enough_or_the_best_in_time(budget, taken, met):
    assert choose(OFFERS, budget) == Choice(OFFERS.index(taken), met)


def test_few_bad_frames_do_not_make_a_point_less_accurate_than_another():
    """Of two in time the one whose vertices are closer, though its worst frames are further off."""
    assert choose([Offer(1e-5, 5e-3, 2e-3), Offer(1e-5, 6e-3, 1e-3)], Budget(time=1e-3)).position == 1


@pytest.mark.parametrize("value", [0.0, -1e-3, float("nan"), float("inf")])
@pytest.mark.parametrize("name", ["time", "error"])
def test_a_budget_is_positive(name, value):
    with pytest.raises(InputError, match=r"budget: .* given; give a positive time in seconds"):
        Budget(**{name: value})


@pytest.fixture
def timed(monkeypatch):
    """As if frames took so many microseconds at each operating point of the synthetic model."""

    def set_times(*microseconds):
        known = {}

        def seconds(ways, model, frames, clock):
            known.update(known or {id(way): 1e-6 * long / MARGIN for way, long in zip(ways, microseconds, strict=True)})
            return np.repeat([[known[id(way)]] for way in ways], frames, axis=1)

        monkeypatch.setattr(choosing, "frame_seconds", seconds)

    return set_times


@pytest.mark.parametrize(
    ("microseconds", "budget", "setting"),
    [
        ((10, 20, 40), Budget(time=5e-5), Setting("polynomial", 6)),
        ((10, 20, 60), Budget(time=5e-5), Setting("polynomial", 3)),
        ((10, 60, 60), Budget(time=5e-5), Setting("superposition", 6)),
        ((10, 20, 40), Budget(error=2e-3), Setting("polynomial", 3)),
        ((10, 40, 20), Budget(error=2e-3), Setting("polynomial", 6)),
    ],
)
def test_an_engine_goes_by_the_times_of_this_machine(synthetic_model, timed, microseconds, budget, setting):
    timed(*microseconds)
    engine = risorius.Engine(synthetic_model, budget=budget)
    assert engine.point.setting == setting
    assert engine.evaluate({"AU12": 0.5}).method == setting.method


@pytest.mark.parametrize(
    ("budget", "expected"),
    [
        (Budget(time=4e-5), [(3, choosing.FEW), (2, choosing.MANY)]),
        (Budget(error=2e-3), [(3, choosing.SOME)]),
    ],
)
def test_only_points_that_most_frames_break_a_budget_with_are_timed_by_few(
    synthetic_model, timed, monkeypatch, budget, expected
):
    timed(10, 90, 40)
    asked, seconds = [], choosing.frame_seconds

    def counted(ways, model, frames, clock):
        asked.append((len(ways), frames))
        return seconds(ways, model, frames, clock)

    monkeypatch.setattr(choosing, "frame_seconds", counted)
    engine = risorius.Engine(synthetic_model, budget=budget)
    assert engine.point.setting == Setting("polynomial", 6)
    assert asked == expected


def test_the_longest_of_many_frames_is_not_held_against_the_longest_of_few(synthetic_model, monkeypatch):
    """One point keeps the budget but in a frame that comes late; the others never do, in the few that are timed."""

    def seconds(ways, model, frames, clock):
        usual = 1e-5 if len(ways) == 1 else np.array([[5e-5], [5e-5], [1e-5]])
        found = np.broadcast_to(usual, (len(ways), frames)).copy()
        found[:, choosing.FEW :] = 9e-5
        return found

    monkeypatch.setattr(choosing, "frame_seconds", seconds)
    engine = risorius.Engine(synthetic_model, budget=Budget(time=4e-5))
    assert engine.point.setting == Setting("polynomial", 6)


def test_without_a_budget_nothing_is_timed_and_the_most_accurate_is_taken(synthetic_model, monkeypatch):
    monkeypatch.setattr(choosing, "frame_seconds", None)
    for budget in (None, Budget()):
        engine = risorius.Engine(synthetic_model, budget=budget)
        assert engine.point.setting == Setting("polynomial", 6)


@pytest.mark.parametrize(
    ("microseconds", "setting"),
    [
        ((10, 20, 900), Setting("polynomial", 6)),
        ((10, 20, 1100), Setting("polynomial", 3)),
        ((2000, 2200, 2400), Setting("polynomial", 6)),
        ((2000, 2200, 2600), Setting("polynomial", 3)),
        ((2000, 2600, 2600), Setting("superposition", 6)),
    ],
)
def test_without_a_budget_it_takes_a_millisecond_or_hardly_longer_than_the_fastest(
    synthetic_model, microseconds, setting
):
    """Of a model trained where everything took longer, the most accurate, not what was the fastest by chance."""
    points = tuple(
        replace(point, seconds=Seconds(1e-6 * long, 2e-6 * long))
        for point, long in zip(synthetic_model.points, microseconds, strict=True)
    )
    assert risorius.Engine(replace(synthetic_model, points=points)).point.setting == setting


def test_a_budget_does_not_change_what_the_scene_asks_for(synthetic_model, timed):
    timed(10)
    engine = risorius.Engine(synthetic_model, risorius.Scene(nonlinear=False), Budget(time=1e-3))
    assert engine.point.setting == Setting("superposition", 6)


def test_a_model_of_superposition_alone_has_nothing_for_a_nonlinear_scene(synthetic_model):
    linear = type(synthetic_model)(**{**vars(synthetic_model), "points": synthetic_model.points[:1]})
    with pytest.raises(InputError, match="'synthetic' has no operating point that lets muscles interact"):
        risorius.Engine(linear)


def test_what_cannot_be_met_is_said_once(synthetic_model, timed, caplog):
    timed(10, 20, 40)
    with caplog.at_level(logging.WARNING):
        engine = risorius.Engine(synthetic_model, budget=Budget(time=3e-5, error=1e-4))
        for _ in range(3):
            engine.evaluate({"AU12": 1.0})
    (record,) = caplog.records
    assert record.getMessage() == (
        "budget of 0.03 ms and 0.1 mm: no operating point of model 'synthetic' keeps it here; the nearest, "
        "polynomial, 3 modes, takes up to 0.02 ms, and 95 % of its frames are within: ordinary 1.33 mm, strong 2 mm"
    )


def test_what_is_met_is_not_talked_about(synthetic_model, timed, caplog):
    timed(10, 20, 40)
    risorius.Engine(synthetic_model, budget=Budget(time=3e-5, error=2e-3))
    assert not caplog.records


def test_fewer_modes_are_the_leading_ones(synthetic_model, timed):
    timed(10, 20, 60)
    fewer = risorius.Engine(synthetic_model, budget=Budget(time=5e-5)).evaluate({"AU12": 1.0, "jaw_open": 0.5})
    every = risorius.Engine(synthetic_model).evaluate({"AU12": 1.0, "jaw_open": 0.5})
    np.testing.assert_array_equal(fewer.coordinates[:7], every.coordinates[:7])
    assert not fewer.coordinates[7:].any()
    expected = synthetic_model.rest_vertices + np.tensordot(fewer.coordinates, synthetic_model.basis, axes=1)
    np.testing.assert_allclose(fewer.vertices, expected, atol=1e-8)


@pytest.mark.parametrize("kind", [Superposition, PolynomialMap, RationalMap])
def test_every_evaluator_gives_leading_modes_alone(kind):
    data = observed(competing, 30)
    evaluator = {
        Superposition: lambda: Superposition(np.random.default_rng(1).normal(size=(5, 3))),
        PolynomialMap: lambda: PolynomialMap.fit(data.parameters, data.coordinates, data.overlap),
        RationalMap: lambda: RationalMap.fit(data),
    }[kind]()
    every, leading = np.empty(3), np.empty(2)
    evaluator.coordinates(data.parameters[0], every)
    evaluator.at(Setting(kind.name, 2)).coordinates(data.parameters[0], leading)
    np.testing.assert_allclose(leading, every[:2], rtol=1e-6)


def test_every_frame_of_every_pipeline_is_timed_alone(synthetic_model):
    ways = pipelines(synthetic_model, [point.setting for point in synthetic_model.points])
    ticks = itertools.count(step=0.5)
    seconds = frame_seconds(ways, synthetic_model, 16, clock=lambda: next(ticks))
    np.testing.assert_array_equal(seconds, np.full((3, 16), 0.5))
    assert next(ticks) == 0.5 * 2 * 3 * 16


def test_half_of_the_timed_frames_are_of_few_inputs(synthetic_model):
    rows = random_weights(synthetic_model.inputs.lower, 384)
    at_work = (rows != 0.0).sum(axis=1)
    assert at_work[1::2].min() == rows.shape[1]
    assert at_work[::2].mean() == pytest.approx(AT_WORK, rel=0.1)


@pytest.mark.parametrize(("long", "times"), [(0, MARGIN), (1, 80.0), (40, 80.0), (100, 160.0)])
def test_the_longest_frame_counts_and_twice_what_a_quarter_exceeds(long, times):
    seconds = np.full((1, 384), 1e-4)
    seconds[0, :long] = 8e-3
    assert cautious(seconds) == pytest.approx(times * 1e-4)
