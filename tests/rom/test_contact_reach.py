"""Contact of a scene looks only at what its inputs can bring to touch, and shows the same."""

from dataclasses import replace

import numpy as np
import pytest
from tests.rom.test_contact import AT_REST, contact_of, depths, lips, on_ball

from risorius import Engine, Scene
from risorius.companion import SKULL
from risorius.contact_geometry import ContactGeometry, Obstacle
from risorius.effects import Surroundings, Touch
from risorius.effects.contact import Contact
from risorius.effects.contact_reach import MARGIN, ReachableContact

TOUCHED = Surroundings(touches=(Touch(0, np.array([0.0, 0.0, -1.0])),))
SHAKEN = Surroundings(gravity=np.array([0.0, -15.0, 0.0]))


def one_side_pressed(rest, depth):
    """The half of a sheet with positive x is pressed down, smoothly."""
    share = np.clip(rest[:, :1] / 3e-3, 0.0, 1.0)
    return (rest - share * [0.0, 0.0, 1e-3 + depth]).astype(np.float32)


def frames_of(rest, *depths):
    return ((AT_REST, one_side_pressed(rest, depth)) for depth in depths)


@pytest.fixture
def reaching():
    contact, rest = on_ball()
    return contact, ReachableContact.of(contact, rest, frames_of(rest, 0.2e-3, 1.5e-3)), rest


def test_what_the_inputs_leave_clear_is_not_looked_at(reaching):
    contact, found, rest = reaching
    left = rest[found.tables.points, 0]
    assert left.min() > -2e-3
    assert 0 < len(left) < 0.7 * len(contact.tables.points)
    moved = np.isin(np.flatnonzero(depths(one_side_pressed(rest, 1.5e-3)) > 0.0), found.tables.points)
    swept = np.isin(np.flatnonzero(depths(one_side_pressed(rest, 1.5e-3)) > 0.0), contact.tables.points)
    np.testing.assert_array_equal(moved, swept)


@pytest.mark.parametrize("depth", [-0.5e-3, 0.3e-3, 0.9e-3, 1.5e-3])
def test_other_frames_of_the_inputs_are_the_same_bit_for_bit(reaching, depth):
    contact, found, rest = reaching
    vertices, expected = one_side_pressed(rest, depth), one_side_pressed(rest, depth)
    found.finish(AT_REST, vertices)
    contact.finish(AT_REST, expected)
    np.testing.assert_array_equal(vertices, expected)


def test_where_something_else_acts_all_is_looked_at(reaching):
    contact, found, rest = reaching
    mirrored = one_side_pressed(rest * np.float32([-1, 1, 1]), 1e-3) * np.float32([-1, 1, 1])
    expected = mirrored.copy()
    contact.finish(AT_REST, expected)
    for surroundings, same in ((Surroundings(), False), (TOUCHED, True), (SHAKEN, True), (Surroundings(), False)):
        vertices = mirrored.copy()
        found.respond(np.zeros(0), AT_REST, np.zeros(0), surroundings)
        found.finish(AT_REST, vertices)
        assert np.array_equal(vertices, expected) == same


def test_a_mouth_that_goes_back_says_so_whatever_acts(reaching):
    contact, _, rest = reaching
    found = ReachableContact.of(contact, rest, frames_of(rest, 20e-3))
    contact.finish(AT_REST, one_side_pressed(rest, 20e-3))
    assert contact.gave_way > 0.0
    for surroundings in (Surroundings(), TOUCHED):
        found.respond(np.zeros(0), AT_REST, np.zeros(0), surroundings)
        found.finish(AT_REST, one_side_pressed(rest, 20e-3))
        assert found.gave_way == pytest.approx(contact.gave_way, rel=1e-6)


def test_a_gap_that_shrinks_keeps_half_as_much_again():
    """Lips that come closer by c are looked at if c and half as much, or MARGIN, is all that was between them."""
    contact, rest = lips(gap=1e-3)
    upper = (np.arange(len(rest)) >= len(rest) // 2)[:, None]

    def looked_at(closer):
        near = (rest - upper * [0.0, closer, 0.0]).astype(np.float32)
        found = ReachableContact.of(contact, rest, [(AT_REST, near)]).tables.vertices
        return len(found) / len(contact.tables.vertices)

    assert MARGIN < 0.5 * 0.6e-3
    assert looked_at(0.6e-3) == 0.0
    assert looked_at(0.7e-3) > 0.5


def test_a_scene_with_contact_shows_what_the_whole_shows(synthetic_model):
    rest, whole = synthetic_model.rest_vertices, Engine(synthetic_model)
    opened, chin = whole.evaluate({"AU26": 1.0}).vertices, rest[:, 1].argmin()
    way = opened[chin] - rest[chin]
    axis = 1e-3 * np.arange(-24, 25)
    away = np.sqrt(sum(np.square(one) for one in np.meshgrid(axis, axis, axis, indexing="ij"))) - 10e-3
    centre = opened[chin] + 8e-3 * way / np.linalg.norm(way)  # the chin opens 2 mm into a ball
    ball = Obstacle(centre + axis[0], 1e-3, np.clip(away, -6e-3, 12e-3).astype(np.float32), SKULL)
    geometry = ContactGeometry({"ball": ball}, np.zeros((0, 2), np.int64))
    made = contact_of(geometry, rest, whole.triangles, opened)
    contact = Contact(made.tables, made.retreat, geometry, len(rest))
    with_contact = replace(synthetic_model, effects={"contact": contact})
    every, few = Engine(with_contact), Engine(with_contact, Scene(inputs=("AU12", "AU26")))
    touched = 0
    rng = np.random.default_rng(0)
    for _ in range(30):
        weights = {"AU12_L": rng.uniform(), "AU12_R": rng.uniform(), "AU26": rng.uniform(0.8, 1.0)}
        expected = every.evaluate(weights).vertices
        touched += not np.array_equal(expected, whole.evaluate(weights).vertices)
        np.testing.assert_allclose(few.evaluate(weights).vertices, expected, atol=1e-5)
    assert touched > 10
