"""The guard on a cube of tissue whose J is known in closed form, and in the engine."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

import risorius
from risorius.effects import Surroundings
from risorius.evaluators import Setting
from risorius.guard import Guard, Verdict, Watch
from risorius.mechanics.body import Body, PassiveElements
from risorius.pipeline import Pipeline
from risorius.reconstruction import reconstruction
from risorius.whole_steps import rounded_fields

STRETCHES = np.zeros((4, 5, 9), np.float32)
"""Coordinate 0 prescribed; the others stretch five points along x, y, z, each point by another part of it."""
for axis in range(3):
    STRETCHES[axis + 1, :, 4 * axis] = np.linspace(0.2, 1.0, 5)

PLACES = np.arange(9.0).reshape(3, 3)


@pytest.fixture
def guard():
    return Guard(Watch(STRETCHES, longest=3.0), lifts=1, size=5)


def jacobians(coordinates):
    return np.prod(1.0 + np.outer(np.linspace(0.2, 1.0, 5), coordinates[1:4]), axis=1)


def test_watched_jacobians_are_determinants():
    state = np.array([7.0, -0.3, 0.4, 1.5])
    np.testing.assert_allclose(Watch(STRETCHES, 1.0).jacobians(state), jacobians(state), rtol=1e-6)


def test_what_tissue_can_have_passes_unchanged(guard):
    state = np.array([1.0, -0.9, 0.5, 0.2, 4.0])
    before = state.copy()
    assert guard.settle(state) is Verdict.GOOD
    np.testing.assert_array_equal(state, before)


def test_a_fold_is_mended_by_the_shortest_way_and_leaves_poses_and_effects_alone(guard):
    state = np.array([1.0, -1.1, 0.0, 0.0, 4.0])
    assert guard.settle(state) is Verdict.MENDED
    assert jacobians(state).min() > 0.0
    # At the worst point J = (1 + x) (1 + y) (1 + z) = -0.1, its gradient (1, -0.1, -0.1), and 0.05 is wanted.
    push = 0.15 / 1.02 * np.array([1.0, -0.1, -0.1])
    np.testing.assert_allclose(state, [1.0, *(np.array([-1.1, 0.0, 0.0]) + push), 4.0], rtol=1e-5)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e200, 13.0])
@pytest.mark.parametrize("place", [1, 3])
def test_an_explosion_is_replaced_by_the_last_good_state_and_the_next_frame_is_free_of_it(guard, bad, place):
    good, exploded = np.array([0.1, 0.2, 0.3, 0.4, 0.5]), np.zeros(5)
    guard.settle(good.copy())
    exploded[place] = bad
    assert guard.settle(exploded) is Verdict.HELD
    np.testing.assert_array_equal(exploded, good)
    after = np.array([0.0, 0.3, 0.0, 0.0, 0.0])
    assert guard.settle(after) is Verdict.GOOD
    assert after[1] == 0.3


def test_the_fold_that_no_mode_can_undo_is_held():
    watch = Watch(np.concatenate([STRETCHES[1:2], 0.0 * STRETCHES[1:]]), longest=3.0)
    guard = Guard(watch, lifts=1, size=4)
    state = np.array([-1.5, 0.0, 0.0, 0.0])
    assert guard.settle(state) is Verdict.HELD
    assert not state.any()


def cubes(count):
    """A row of linear tetrahedra that share no node, and their nodes."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    nodes = np.concatenate([corners + np.array([2.0 * k, 0.0, 0.0]) for k in range(count)])
    slopes = np.array([[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    table = PassiveElements(
        np.arange(4 * count).reshape(count, 4),
        np.tile(slopes, (count, 1, 1, 1)),
        np.full((count, 1), 1.0 / 6.0),
        np.ones((count, 3)),
    )
    none = sp.csr_matrix((6 * count, 0)), sp.csr_matrix((12 * count, 0))
    return Body((table,), (), *none, np.zeros(4 * count, bool)), nodes


def test_points_are_chosen_where_states_fold():
    body, nodes = cubes(200)
    fields = np.zeros((2, len(nodes), 3))
    for mode, element in enumerate((50, 150)):
        fields[mode, 4 * element + 1, 0] = 1.0
    states = np.array([[0.5, 0.5], [-2.0, 0.0], [0.0, -2.0]])
    watch = Watch.choose(body, nodes, fields, 0, states[:1], states[1:])
    assert len(watch) < 200
    np.testing.assert_allclose(watch.jacobians(np.array([-2.0, 0.0])).min(), -1.0)
    np.testing.assert_allclose(watch.jacobians(np.array([0.0, -2.0])).min(), -1.0)
    assert watch.longest == pytest.approx(np.sqrt(0.5))
    folded = [watch.places[watch.jacobians(state) < 0.0] for state in states[1:]]
    middles = [nodes[4 * element : 4 * element + 4].mean(axis=0, keepdims=True) for element in (50, 150)]
    np.testing.assert_allclose(folded, middles)


@pytest.fixture
def watched_model(synthetic_model):
    """The synthetic model with tissue that folds where the modal coordinates come to 0.95 and more."""
    gradients = np.zeros((synthetic_model.rank, 3, 9), np.float32)
    gradients[synthetic_model.lifts :, :, 0] = -1.0 / 0.95
    return replace(synthetic_model, watch=Watch(rounded_fields(gradients), longest=3.0, places=PLACES))


def test_a_mended_frame_says_so_and_states_what_it_may_be_off(watched_model, synthetic_model):
    ours, free = (risorius.Engine(model).evaluate({"AU12": 1.0}) for model in (watched_model, synthetic_model))
    assert (ours.method, ours.converged) == ("polynomial, mended", True)
    assert watched_model.watch.jacobians(ours.coordinates).min() > 0.0
    moved = np.linalg.norm(ours.vertices - free.vertices, axis=1).max()
    assert 0.0 < moved <= ours.error - free.error


def test_a_frame_without_folds_is_the_same_with_and_without_a_watch(watched_model, synthetic_model):
    ours, free = (risorius.Engine(model).evaluate({"AU12_L": 0.5}) for model in (watched_model, synthetic_model))
    np.testing.assert_array_equal(ours.vertices, free.vertices)
    assert (ours.method, ours.error) == (free.method, free.error)


class Bomb:
    """An effect that blows up in one frame, in its coordinates or in the vertices, and would go on if it were kept."""

    name = "bomb"
    gave_way = 0.0
    fields = np.zeros((1, 320, 3), np.float32)

    def __init__(self, where):
        self.where, self.lit = where, False

    def drive(self, parameters, surroundings):
        self.lit = self.lit or surroundings.step is not None

    def respond(self, parameters, coordinates, own, surroundings):
        own[0] = np.nan if self.lit and self.where == "coordinates" else 0.0

    def finish(self, coordinates, vertices, folds):
        if self.lit and self.where == "vertices":
            vertices[3, 1] = 1e9

    def restart(self):
        self.lit = False

    def at(self, setting):
        return Bomb(self.where)


@pytest.mark.parametrize("where", ["coordinates", "vertices"])
def test_an_effect_that_explodes_is_started_anew(synthetic_model, where):
    surface = reconstruction(synthetic_model.carried_basis.followed_by([Bomb.fields]), synthetic_model.rest_vertices)
    pipeline = Pipeline(synthetic_model, Setting("polynomial", 6), surface, [Bomb(where)])
    vertices, verdicts = np.empty_like(synthetic_model.rest_vertices), []
    parameters = np.array([0.5, 0.5, 0.0, 0.0, 0.0])
    for step in (None, 1e-3, None):
        pipeline.solve(parameters, Surroundings(step=step))
        pipeline.write(vertices)
        assert np.abs(vertices).max() < 0.2
        verdicts.append(pipeline.verdict)
    assert verdicts == [Verdict.GOOD, Verdict.HELD, Verdict.GOOD]


class Listener(Bomb):
    """An effect that does nothing, and remembers where it was told that tissue was folded."""

    def finish(self, coordinates, vertices, folds):
        self.told = folds

    def at(self, setting):
        return self


@pytest.mark.parametrize("places", [PLACES, None])
def test_effects_are_told_of_tissue_that_was_mended(watched_model, places):
    watched_model = replace(watched_model, watch=replace(watched_model.watch, places=places))
    surface = reconstruction(watched_model.carried_basis.followed_by([Bomb.fields]), watched_model.rest_vertices)
    listener, vertices = Listener("nowhere"), np.empty_like(watched_model.rest_vertices)
    pipeline = Pipeline(watched_model, Setting("polynomial", 6), surface, [listener])
    for activation, folds in ((0.1, np.empty((0, 3))), (1.0, places)):
        pipeline.solve(np.array([activation, activation, 0.0, 0.0, 0.0]))
        pipeline.write(vertices)
        np.testing.assert_array_equal(listener.told, folds)


def test_a_watch_comes_back_from_the_file(watched_model, tmp_path):
    watched_model.save(tmp_path / "model.h5")
    loaded = risorius.load(tmp_path / "model.h5").watch
    np.testing.assert_array_equal(loaded.gradients, watched_model.watch.gradients)
    assert loaded.longest == watched_model.watch.longest
    np.testing.assert_array_equal(loaded.places, PLACES)


def test_places_of_a_watch_turn_with_the_axes_of_its_model(watched_model):
    np.testing.assert_array_equal(watched_model.in_axes((2, 0, 1)).watch.places, PLACES[:, [2, 0, 1]])


def test_a_part_watches_what_its_inputs_squeeze_and_its_coordinates_tell():
    """Points are squeezed by the first coordinate; by the last, which is lost; by both, the last a little; by none."""
    gradients = np.zeros((3, 4, 9), np.float32)
    gradients[0, [0, 2, 3], 0] = -1.0, -1.0, -0.1
    gradients[2, [1, 2], 0] = -1.0, -0.01
    watch = Watch(gradients, longest=3.0)
    states = np.array([[0.8, 0.0, 0.9], [0.0, 0.0, 0.0]])
    part = watch.within(np.array([0, 1]), states)
    np.testing.assert_array_equal(part.gradients, gradients[:2][:, [0, 2]])
    assert watch.within(np.array([0, 1]), 0.1 * states) is None
