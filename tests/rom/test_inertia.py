"""The inertia effect against the exact solution of its equations, at every frame rate."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.linalg import expm

from risorius.effects.effect import UPRIGHT, Surroundings, Touch
from risorius.effects.inertia import Inertia
from risorius.effects.lag import OutsideLoads
from risorius.effects.strain_lag import StrainLag
from risorius.effects.vibrations import Vibrations
from risorius.errors import InputError
from risorius.mechanics.material import MASS_DAMPING, STIFFNESS_DAMPING

STEPS = [1e-4, 1e-3, 1e-2, 1e-1]
SQUARES = np.array([1.0, 50.0, 315.0, 3e3, 1e6, 1e9])  # the third is nearest to critical damping


DAMPINGS = MASS_DAMPING + STIFFNESS_DAMPING * SQUARES * np.array([1.0, 0.02, 1.0, 0.5, 1.0, 0.9])  # the second swings


def effect(muscles=2, shares=None, times=None):
    count = len(SQUARES)
    shares = np.zeros((muscles, count - 1)) if shares is None else shares
    times = np.full(muscles, STIFFNESS_DAMPING) if times is None else times
    vibrations, strain_lag = Vibrations(SQUARES, DAMPINGS), StrainLag(shares, times)
    return Inertia(np.zeros((count, 5, 3), np.float32), vibrations, np.eye(count), 1, strain_lag)


def frame(inertia, parameters, coordinates, step):
    """Parameters that act, and the vibration, after a frame."""
    driven, own = np.array(parameters, dtype=float), np.empty(len(SQUARES))
    surroundings = inertia.drive(driven, Surroundings(step))
    inertia.respond(driven, np.array(coordinates, dtype=float), own, surroundings)
    return driven, own


def exact(square, c, s0, s1, y, v, step):
    """y'' + c y' + w^2 y = w^2 s + (c - alpha) s', s linear: the matrix exponential with s and s' as further states."""
    matrix = np.array([[0, 1, 0, 0], [-square, -c, square, c - MASS_DAMPING], [0, 0, 0, 1], [0, 0, 0, 0]])
    return (expm(matrix * step) @ [y, v, s0, (s1 - s0) / step])[:2]


@pytest.mark.parametrize("step", STEPS)
def test_vibrations_are_the_exact_solution_for_motion_that_is_linear_within_a_frame(step):
    inertia, rng = effect(), np.random.default_rng(0)
    s = rng.normal(size=(6, len(SQUARES)))
    frame(inertia, [0, 0], s[0], step)
    states = np.column_stack([s[0], np.zeros(len(SQUARES))])
    for before, now in itertools.pairwise(s):
        _, own = frame(inertia, [0, 0], now, step)
        terms = zip(SQUARES, DAMPINGS, before, now, states, strict=True)
        states = np.array([exact(square, c, s0, s1, *state, step) for square, c, s0, s1, state in terms])
        np.testing.assert_allclose(own, states[:, 0] - now, atol=1e-8 * np.abs(s).max())


@pytest.mark.parametrize("step", STEPS)
def test_loads_lag_exactly_and_bones_do_not(step):
    """Between frames the activations asked for are linear: y(t) = a + b (t - tau) + C exp(-t / tau)."""
    inertia = effect()
    frame(inertia, [0.0, 0.0, 0.0], np.zeros(len(SQUARES)), None)
    for number in range(1, 6):
        driven, _ = frame(inertia, [number * step, 0.0, 0.7], np.zeros(len(SQUARES)), step)
        time, tau = number * step, STIFFNESS_DAMPING
        assert driven[0] == pytest.approx(time - tau + tau * np.exp(-time / tau), abs=1e-12)
        assert driven[2] == 0.7


@pytest.mark.parametrize("step", STEPS)
def test_strained_tissue_misses_what_lags_behind_two_thirds_of_the_power_of_its_load(step):
    """e = E (phi - z), z' = (phi - z) / time, phi = 2/3 y^1.5 linear within a frame; E of each muscle by itself."""
    shares, times = np.random.default_rng(5).normal(size=(2, len(SQUARES) - 1)), np.array([0.03, 0.05])
    inertia, before, behind = effect(2, shares, times), np.zeros(2), np.zeros(2)
    frame(inertia, [0.0, 0.0], np.zeros(len(SQUARES)), None)
    for loads in ([1.0, 0.0], [1.0, 0.4], [0.3, 0.0], [0.0, 0.0]):
        coordinates = np.zeros(len(SQUARES))
        driven = np.array(loads)
        acting = inertia.drive(driven, Surroundings(step))
        inertia.respond(driven, coordinates, np.empty(len(SQUARES)), acting)
        now = 2.0 / 3.0 * driven**1.5
        for k, time in enumerate(times):
            solution = expm(np.array([[-1 / time, 1 / time, 0], [0, 0, 1], [0, 0, 0]]) * step)
            behind[k] = (solution @ [behind[k], before[k], (now[k] - before[k]) / step])[0]
        before = now
        np.testing.assert_allclose(coordinates, [0.0, *((now - behind) @ shares)], atol=1e-12)


@pytest.mark.parametrize("step", [*STEPS, 10.0])
def test_energy_of_what_nothing_pushes_never_grows(step):
    """1/2 y'^2 + 1/2 w^2 d^2 of the modes, and the loads that are left of a jump."""
    inertia, rng = effect(), np.random.default_rng(3)
    frame(inertia, [1.0, 0.6], rng.normal(size=len(SQUARES)), None)
    still, energies, loads = rng.normal(size=len(SQUARES)), [], []
    for _ in range(60):
        driven, own = frame(inertia, [0.0, 0.0], still, step)
        energies.append(0.5 * inertia._vibrations._speed**2 + 0.5 * SQUARES * own**2)
        loads.append(driven)
    assert np.isfinite(energies).all()
    assert (np.diff(energies, axis=0) <= 1e-12 * np.abs(energies[:-1])).all()
    assert (np.diff(loads, axis=0) <= 0.0).all()


def test_frames_of_changing_length_stay_bounded_under_wild_input():
    inertia, rng = effect(), np.random.default_rng(4)
    for _ in range(2000):
        step = 10.0 ** rng.uniform(-4, -1)
        driven, own = frame(inertia, rng.integers(0, 2, 2), rng.uniform(-1, 1, len(SQUARES)), step)
        assert ((driven >= 0.0) & (driven <= 1.0)).all()
        assert np.abs(own).max() < 5.0


def test_a_frame_without_a_step_is_at_rest_under_its_loads_whatever_was_before():
    inertia = effect()
    frame(inertia, [0.0, 0.0], np.zeros(len(SQUARES)), 0.01)
    frame(inertia, [1.0, 0.0], np.ones(len(SQUARES)), 0.01)
    driven, own = frame(inertia, [0.4, 0.2], np.full(len(SQUARES), 3.0), None)
    np.testing.assert_array_equal(driven, [0.4, 0.2])
    assert not own.any()


@pytest.mark.parametrize("step", [0.0, -0.01, np.nan, np.inf])
def test_a_step_that_is_no_time_is_refused(step):
    with pytest.raises(InputError, match=r"step .* s; give the seconds since the last frame"):
        effect().check(Surroundings(step))


def test_weight_and_touches_lag_too_and_a_touch_that_ends_is_gone_in_the_end():
    loads = OutsideLoads(0.05)
    assert loads.take(Surroundings(0.1), 0.1) == Surroundings(0.1)
    for number in range(1, 4):
        acting = loads.take(Surroundings(0.1, np.array([9.81, 0.0, 0.0]), (Touch(3, [0.0, 0.0, -1.0]),)), 0.1)
        left = 0.05 / 0.1 * (1 - np.exp(-2.0)) * np.exp(-2.0 * (number - 1))
        np.testing.assert_allclose(acting.touches[0].force, [0.0, 0.0, left - 1.0], atol=1e-12)
        np.testing.assert_allclose(acting.gravity, UPRIGHT + (1 - left) * np.array([9.81, 9.81, 0.0]), atol=1e-12)
    for _ in range(20):
        acting = loads.take(Surroundings(0.1), 0.1)
    assert acting.touches == ()
    assert acting.gravity is None
