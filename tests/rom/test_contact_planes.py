"""Planes between lips only ever bound: against distances from every triangle, and on ways that pass through."""

import math

import numba
import numpy as np
import pytest
from tests.rom.test_contact import SIDE, closed, lips, random_lips

from risorius.closest_point import closest_point
from risorius.effects.contact_groups import RIM
from risorius.effects.contact_planes import TOLD, beyond_planes


@pytest.fixture(scope="module")
def sheets():
    """Contact of two sheets 1 mm apart."""
    return lips()


def told(contact, vertices):
    """Bounds of the gaps (l,) of all points."""
    gaps = np.empty(len(contact.tables.vertices))
    beyond_planes(vertices, contact.tables.vertices, contact.groups.kernel(contact.tables.vertices), gaps)
    return gaps


@numba.njit
def _distances(x, points, triangles, sheet):
    """From the nearest triangle of the other sheet, (l,)."""
    found = np.full(len(points), np.inf)
    for n in range(len(points)):
        p = x[points[n]]
        for a, b, c in triangles:
            if (a >= sheet) != (points[n] >= sheet):
                square = closest_point(
                    p[0], p[1], p[2], x[a, 0], x[a, 1], x[a, 2], x[b, 0], x[b, 1], x[b, 2], x[c, 0], x[c, 1], x[c, 2]
                )[0]
                found[n] = min(found[n], math.sqrt(square))
    return found


def distances(contact, vertices):
    return _distances(vertices, contact.tables.vertices, contact.tables.triangles, SIDE**2)


def opened(rest, by):
    """The upper sheet is lifted."""
    return (rest + (np.arange(len(rest)) >= SIDE**2)[:, None] * [0.0, by, 0.0]).astype(np.float32)


def inside(contact, rest, farther=RIM):
    """Which of the points (l,) lie farther from where the other sheet ends."""
    t = contact.tables
    ends = np.unique(np.concatenate([t.triangles[t.across[:, k] < 0][:, [k, (k + 1) % 3]] for k in range(3)]))
    apart = np.linalg.norm(rest[t.vertices][:, None] - rest[ends], axis=2)
    same = (t.vertices[:, None] >= SIDE**2) == (ends >= SIDE**2)
    return np.where(same, np.inf, apart).min(axis=1) >= farther


def test_planes_at_rest_tell_the_whole_gap_of_sheets_that_are_parallel():
    contact, rest = lips(gap=0.6e-3)
    np.testing.assert_allclose(told(contact, rest)[inside(contact, rest)], 0.6e-3, rtol=0.05)


def test_lips_that_are_far_apart_are_clear_without_a_plane(sheets):
    contact, rest = sheets
    np.testing.assert_array_equal(told(contact, opened(rest, 30e-3))[inside(contact, rest)], TOLD)


def test_points_at_the_rim_of_the_other_lip_around_which_they_may_get_behind_it_are_left_to_others(sheets):
    contact, rest = sheets
    rim = ~inside(contact, rest)
    assert rim.any()
    np.testing.assert_array_equal(told(contact, opened(rest, 2e-3))[rim], 0.0)


def test_no_bound_is_more_than_the_distance_from_any_triangle(sheets):
    contact, rest = sheets
    rng, clear = np.random.default_rng(3), 0
    for _ in range(4):
        vertices = random_lips(rest, rng)
        bounds = told(contact, vertices)
        assert (bounds <= distances(contact, vertices) + 1e-6).all()
        clear += np.count_nonzero(bounds)
    assert clear > 1000


@pytest.mark.parametrize("overlap", [0.1e-3, 2e-3])
def test_what_is_behind_the_other_lip_is_never_clear(sheets, overlap):
    contact, rest = sheets
    vertices = closed(rest, overlap)
    lower, upper = np.split(vertices[:, 1], 2)  # opposite each other
    behind = np.isin(contact.tables.vertices % SIDE**2, np.flatnonzero(lower > upper))
    assert behind.any()
    assert (told(contact, vertices)[behind] == 0.0).all()


@pytest.mark.parametrize("through", [3e-3, 15e-3, 60e-3])
def test_a_lip_that_has_gone_through_the_other_is_not_clear_however_far_it_has_gone(sheets, through):
    contact, rest = sheets
    assert (told(contact, opened(rest, -through))[inside(contact, rest)] == 0.0).all()


def test_a_part_of_the_points_is_told_the_same(sheets):
    contact, rest = sheets
    every_other = np.arange(len(contact.tables.vertices)) % 2 == 0
    fewer = type(contact)(
        contact.tables.only(np.ones(len(contact.tables.points), bool), every_other),
        *(contact.retreat, contact.geometry, 5),
    )
    vertices = random_lips(rest, np.random.default_rng(5))
    np.testing.assert_array_equal(told(fewer, vertices), told(contact, vertices)[every_other])
