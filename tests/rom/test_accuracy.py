"""Errors on held-out snapshots, against distances added up by hand."""

import numpy as np
import pytest

from risorius.accuracy import HeldOut, conformal_quantile


@pytest.fixture
def held():
    """Three snapshots of two vertices, of which every vertex moves 5 mm."""
    moved = np.full((3, 2, 3), [3e-3, 4e-3, 0.0], np.float32)
    return HeldOut(np.zeros((3, 1)), np.zeros((3, 0)), ("ordinary", "strong", "ordinary"), moved)


def test_errors_are_distances_and_kinds_are_apart(held):
    errors = held.errors([np.zeros((2, 3)), held.displacements[1], np.array([[3e-3, 0, 0], [3e-3, 4e-3, 0]])])
    np.testing.assert_allclose(errors, [[5e-3, 5e-3], [0, 0], [4e-3, 0]], rtol=1e-6, atol=1e-9)
    found = held.by_kind(errors)
    assert list(found) == ["ordinary", "strong"]
    assert found["ordinary"].mean == pytest.approx(3.5e-3)
    assert found["ordinary"].maximum == found["ordinary"].frame == pytest.approx(5e-3)
    assert found["ordinary"].relative == pytest.approx(0.5 * (1.0 + 4.0 / np.hypot(5, 5)))
    assert (found["ordinary"].count, found["strong"].count, held.overall(errors).count) == (2, 1, 3)
    assert found["strong"].maximum == 0.0
    assert held.overall(errors).mean == pytest.approx(14e-3 / 6)


@pytest.mark.parametrize(("count", "rank"), [(5, 5), (19, 19), (20, 20), (39, 38), (99, 95)])
def test_a_conformal_quantile_is_the_score_of_its_rank(count, rank):
    """ceil(0.95 (n + 1)) of n (Vovk et al. 2005)."""
    assert conformal_quantile(np.random.default_rng(0).permutation(count) + 1.0) == rank
