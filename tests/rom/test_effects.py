"""What scenes ask of a model's effects, and what frames are told of the world around the face."""

from __future__ import annotations

import numpy as np
import pytest

import risorius
from risorius.errors import InputError

SMILE = {"AU12": 1.0}


def test_a_scene_builds_the_effects_of_the_model_unless_they_are_off(lively_model, synthetic_model):
    assert risorius.Engine(lively_model).effects == ("inertia", "gravity", "touch")
    assert risorius.Engine(lively_model, risorius.Scene(inertia=False)).effects == ("gravity", "touch")
    assert risorius.Engine(synthetic_model).effects == ()


@pytest.mark.parametrize("effect", ["inertia", "gravity", "touch"])
def test_an_effect_that_the_model_lacks_is_refused_with_what_it_takes(synthetic_model, effect):
    with pytest.raises(InputError, match=rf"scene: {effect}: model 'synthetic' is without; train it from"):
        risorius.Engine(synthetic_model, risorius.Scene(**{effect: True}))


@pytest.mark.parametrize(
    ("argument", "message"),
    [
        ({"step": 0.01}, "step: the scene of this engine is without inertia"),
        ({"gravity": (9.81, 0.0, 0.0)}, "gravity: the scene of this engine is without gravity"),
        ({"touches": [risorius.Touch(3, (0.0, 0.0, 1.0))]}, "touches: the scene of this engine is without touch"),
    ],
)
def test_what_no_effect_of_the_scene_shows_is_refused(synthetic_model, argument, message):
    with pytest.raises(InputError, match=message):
        risorius.Engine(synthetic_model).evaluate(SMILE, **argument)


def test_a_model_with_effects_is_the_same_from_its_file(lively_model, tmp_path):
    lively_model.save(tmp_path / "model.h5")
    engines = [risorius.Engine(model) for model in (lively_model, risorius.load(tmp_path / "model.h5"))]
    for step in (None, 0.01, 0.02, 0.01):
        arguments = {"step": step, "gravity": (0.0, 0.0, -9.81), "touches": [risorius.Touch(7, (0.0, 0.1, -0.2))]}
        ours, theirs = (engine.evaluate(SMILE if step else {}, **arguments).vertices for engine in engines)
        np.testing.assert_array_equal(ours, theirs)


def test_a_smile_takes_its_time_and_ends_as_it_is_without_inertia(lively_model):
    engine = risorius.Engine(lively_model)
    rest, still = engine.evaluate({}).vertices, engine.evaluate(SMILE).vertices
    engine.evaluate({})
    sizes = [np.abs(engine.evaluate(SMILE, step=0.02).vertices - rest).max() for _ in range(40)]
    assert sizes[0] < 0.5 * sizes[-1]
    assert sizes[-1] == pytest.approx(np.abs(still - rest).max(), rel=1e-5)


def test_a_refused_frame_leaves_the_motion_as_it_was(lively_model):
    disturbed, calm = risorius.Engine(lively_model), risorius.Engine(lively_model)
    for engine in (disturbed, calm):
        engine.evaluate({})
        engine.evaluate(SMILE, step=0.02)
    refused = [{"step": -1.0}, {"step": 0.02, "out": np.zeros((3, 3), np.float32)}, {"gravity": (0.0, np.nan, 0.0)}]
    refused += [{"step": 0.02, "touches": [risorius.Touch(vertex, (0.0, 0.0, -9.0))]} for vertex in (-1, 3, 320)]
    for arguments in refused:
        with pytest.raises(InputError):
            disturbed.evaluate({"AU12": 0.2}, **arguments)
    frames = [engine.evaluate(SMILE, step=0.02).vertices for engine in (disturbed, calm)]
    np.testing.assert_array_equal(*frames)


def test_vertices_in_other_axes_move_alike(lively_model):
    order = (2, 0, 1)
    engines = risorius.Engine(lively_model), risorius.Engine(lively_model.in_axes(order))
    for engine in engines:
        engine.evaluate({})
    outside = {"gravity": (3.0, 0.0, -9.0), "touches": [risorius.Touch(40, (0.1, 0.2, -0.3))]}
    ours, turned = (engine.evaluate(SMILE, step=0.02, **outside).vertices for engine in engines)
    np.testing.assert_allclose(ours[:, order], turned, atol=1e-8)


def test_effects_that_are_restarted_know_nothing_of_the_frames_before(lively_model):
    disturbed, calm = risorius.Engine(lively_model), risorius.Engine(lively_model)
    tilted, pushed = (6.0, -7.0, 1.0), [_touch(17, 0.02)]
    for weight in (1.0, 0.2, 0.9):
        disturbed.evaluate({"AU12": weight}, step=0.01, gravity=tilted, touches=pushed)
    for effect in (*disturbed._pipeline._effects, *calm._pipeline._effects):
        effect.restart()
        assert effect.energy == 0.0
    for weight in (0.0, 0.5, 0.7):
        found, expected = (e.evaluate({"AU12": weight}, step=0.01, gravity=tilted) for e in (disturbed, calm))
        np.testing.assert_array_equal(found.vertices, expected.vertices)
        np.testing.assert_array_equal(found.coordinates, expected.coordinates)


def test_a_head_that_lies_down_sags_with_the_lag_of_its_tissue(lively_model):
    lying = {"gravity": (0.0, 0.0, -9.81)}
    engine, without = risorius.Engine(lively_model), risorius.Engine(lively_model, risorius.Scene(inertia=False))
    upright, still = (without.evaluate(SMILE, **arguments).vertices for arguments in ({}, lying))
    assert np.abs(still - upright).max() > 1e-4
    engine.evaluate(SMILE)
    sagging = [engine.evaluate(SMILE, step=0.02, **lying).vertices for _ in range(40)]
    assert np.abs(sagging[0] - upright).max() < 0.5 * np.abs(still - upright).max()
    np.testing.assert_allclose(sagging[-1], still, atol=1e-7)


def test_a_touch_moves_its_vertex_and_leaves_nothing_behind(lively_model):
    engine = risorius.Engine(lively_model, risorius.Scene(inertia=False))
    touched, free = (engine.evaluate(SMILE, touches=touches).vertices for touches in ([_touch(9, 0.2)], []))
    moved = touched - free
    stiffness = np.linspace(100.0, 300.0, 3 * len(free))[3 * 9 + 2]
    assert moved[9, 2] == pytest.approx(0.2 / stiffness, rel=1e-4)
    assert np.abs(np.delete(moved, 9, axis=0)).max() == 0.0


def test_a_region_is_touched_by_the_numbers_of_its_own_vertices(lively_model):
    whole, part = (
        risorius.Engine(lively_model, risorius.Scene(inertia=False, region=region))
        for region in ("full", tuple(range(100, 200)))
    )
    number = int(np.flatnonzero(part.vertex_numbers == 150)[0])
    ours = whole.evaluate(SMILE, touches=[_touch(150, 0.2)]).vertices[part.vertex_numbers]
    theirs = part.evaluate(SMILE, touches=[_touch(number, 0.2)]).vertices
    np.testing.assert_allclose(ours, theirs, atol=1e-5)
    assert np.abs(ours - whole.evaluate(SMILE).vertices[part.vertex_numbers]).max() > 5e-4


@pytest.mark.parametrize(
    ("vertex", "force", "message"),
    [
        (320, 0.1, "touch: there is no vertex 320; give one of 0 to 319"),
        (-1, 0.1, "touch: there is no vertex -1"),
        (3.5, 0.1, "touch: there is no vertex 3.5"),
        (5, 9.0, r"touch: 9 N on 5 moves the skin by 86.9 mm, more than the 5 mm"),
    ],
)
def test_touches_that_the_model_cannot_show_are_refused(lively_model, vertex, force, message):
    with pytest.raises(InputError, match=message):
        risorius.Engine(lively_model).evaluate(SMILE, touches=[_touch(vertex, force)])


@pytest.mark.parametrize("force", [(0.0, 0.0, np.inf), (0.0, 1.0), "much"])
def test_a_force_is_three_finite_numbers(force):
    with pytest.raises(InputError, match=r"touch of vertex 3: force .*; give three finite numbers"):
        risorius.Touch(3, force)


def _touch(vertex, force):
    return risorius.Touch(vertex, (0.0, 0.0, force))
