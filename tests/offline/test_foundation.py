"""What is expected of a sample from the first ones of its file."""

import numpy as np
import pytest

from risorius.snapshot_file import FAILED, SOLVED
from risorius_offline.foundation import FEWEST, IN_WORK, MOST, Interpolation, foundation

NODES = 5
FIELDS = np.random.default_rng(1).normal(size=(3, NODES, 3))


class Store:
    """Solved samples of two muscles and one pose, whose motion tissue follows by sin(w) times a field."""

    def __init__(self, count):
        self.parameters = np.random.default_rng(2).uniform(0.0, 1.0, (count, 3))
        self.states = np.full(count, SOLVED, np.uint8)

    def following(self, parameters):
        return np.sin(parameters[2]) * FIELDS[2]

    def exact(self, parameters):
        a, b, _ = parameters
        return 1e-3 * (a * FIELDS[0] + b * FIELDS[1] + 0.3 * a * b * FIELDS[0]) + self.following(parameters)

    def displacement(self, row):
        return self.exact(self.parameters[row]).astype(np.float32)


def test_only_samples_that_nobody_works_on_are_asked_and_their_number_grows_by_doubling():
    counts = [foundation(row) for row in range(4 * MOST)]
    assert all(count <= max(row - IN_WORK, 0) for row, count in enumerate(counts))
    assert sorted(set(counts)) == [0, FEWEST, 2 * FEWEST, 4 * FEWEST, MOST]
    assert counts == sorted(counts)


def test_a_smooth_dependence_is_found_between_samples():
    store = Store(64)
    expected = Interpolation.of(store, 64)
    wanted = np.array([0.4, 0.6, 0.5])
    beside = store.exact(wanted) - store.following(wanted)
    error = expected.displacement(wanted) - store.exact(wanted)
    assert np.abs(error).max() < 0.01 * np.abs(beside).max()


def test_bones_are_followed_beyond_all_samples():
    store = Store(64)
    far = np.array([0.0, 0.0, 3.0])
    found = Interpolation.of(store, 64).displacement(far)
    np.testing.assert_allclose(found, store.following(far), atol=5e-4)


def test_nothing_is_expected_to_move_at_rest():
    found = Interpolation.of(Store(64), 64).displacement(np.zeros(3))
    np.testing.assert_allclose(found, 0.0, atol=1e-9)


@pytest.mark.parametrize("others", [1e3, np.nan])
def test_samples_that_failed_or_come_later_are_not_asked(others):
    store, alone = Store(96), Store(96)
    store.states[3] = alone.states[3] = FAILED
    displacement = store.displacement
    store.displacement = lambda row: displacement(row) if row < 64 and row != 3 else np.full((NODES, 3), others)
    wanted = np.array([0.4, 0.6, 0.5])
    found, same = (Interpolation.of(each, 64).displacement(wanted) for each in (store, alone))
    np.testing.assert_array_equal(found, same)


def test_without_any_equilibrium_nothing_is_expected():
    store = Store(64)
    store.states[:] = FAILED
    assert Interpolation.of(store, 64) is None
