"""Mirror images of a symmetric face, its modes, what they are made for, and derivatives in them."""

from dataclasses import replace

import numpy as np
import pytest
from tests.rom.test_training import JAW, made_up_snapshots

from risorius.bases import pod
from risorius.modal import MOST_NEIGHBOURS, STEP, VISIBLE_SHARE, directional_derivatives, symmetric_pod, visible_measure
from risorius.symmetry import ACROSS, Mirror, mirror_of
from risorius.training import project


def symmetric_snapshots():
    """The made-up face with its nodes and its two muscles' displacements in mirror images."""
    snapshots, _ = made_up_snapshots(20, 5)
    half = snapshots.points[:30]
    points = np.concatenate([half, half * ACROSS])
    nodes = np.concatenate([np.arange(30, 60), np.arange(30)])
    displacements = np.zeros_like(snapshots.displacements)
    field = np.random.default_rng(0).normal(size=(60, 3)) * 1e-3
    lifts = JAW.unit_motions(points)
    for out, p in zip(displacements, snapshots.parameters, strict=True):
        other = field[nodes] * ACROSS
        out[:] = p[0] * field + p[1] * other + np.tensordot(JAW.lift_coordinates(p[2:]), lifts, axes=1)
    changed = {"points": points, "displacements": displacements, "lift_fields": lifts, "derivatives": None}
    return replace(snapshots, **changed), nodes


def test_a_symmetric_face_is_recognised():
    snapshots, nodes = symmetric_snapshots()
    mirror = mirror_of(snapshots, snapshots.single_actions())
    assert mirror is not None
    np.testing.assert_array_equal(mirror.nodes, nodes)
    np.testing.assert_array_equal(mirror.partner, [1, 0, 2, 3, 4])
    np.testing.assert_array_equal(mirror.sign, [1, 1, 1, 1, -1])


def test_a_face_whose_sides_move_differently_is_not_symmetric():
    snapshots, _ = symmetric_snapshots()
    snapshots.displacements[0] *= 1.01
    assert mirror_of(snapshots, snapshots.single_actions()) is None


@pytest.mark.parametrize(("share", "symmetric"), [(0.015, True), (0.03, False)])
def test_nodes_that_contact_left_elsewhere_do_not_make_a_face_asymmetric(share, symmetric, caplog):
    """Three of sixty nodes, by a share of the whole displacement; the others where they were."""
    snapshots, _ = symmetric_snapshots()
    snapshots.displacements[0, :3, 0] += share * np.linalg.norm(snapshots.displacements[0]) / np.sqrt(3)
    assert (mirror_of(snapshots, snapshots.single_actions()) is not None) == symmetric
    assert ("zygomaticus_major_L moves it otherwise" in caplog.text) != symmetric


def test_a_face_whose_nodes_lie_differently_is_not_symmetric():
    snapshots, _ = symmetric_snapshots()
    snapshots.points[3] += 1e-4
    assert mirror_of(snapshots, snapshots.single_actions()) is None


def test_symmetric_modes_are_those_of_snapshots_and_images_together():
    rng = np.random.default_rng(1)
    nodes = np.concatenate([np.arange(20, 40), np.arange(20)])
    mirror = Mirror(nodes, np.arange(1), np.ones(1))
    data, weights = (
        rng.normal(size=(12, 40, 3)) * 0.6 ** np.arange(12)[:, None, None],
        np.tile(rng.uniform(1, 2, 20), 2),
    )
    modes, parity = symmetric_pod(lambda: [data], weights, 6, mirror)
    images = mirror.image(modes)
    np.testing.assert_allclose(images, parity[:, None, None] * modes, atol=1e-10)
    both = np.concatenate([data, mirror.image(data)])
    expected, _ = pod(lambda: [both], weights, 6)
    shared = np.einsum("rni,n,sni->rs", modes, weights, expected)
    np.testing.assert_allclose(np.abs(shared), np.eye(6), atol=1e-5)


def test_modal_derivatives_are_the_slopes_of_the_coordinates():
    snapshots, _ = made_up_snapshots(60, 10)
    modal = project(snapshots, 8)
    assert modal.derivatives is not None
    a, b, opening, _, _ = snapshots.parameters[~snapshots.held_out].T
    # The made-up coordinates, of which those in the modes are linear combinations, and their derivatives.
    made_up = np.column_stack([a + 0.2 * a * a, b, 0.4 * a * b, 0.1 * opening * a])
    slope = np.zeros((len(a), 5, 4))
    slope[:, 0] = np.column_stack([1.0 + 0.4 * a, 0.0 * a, 0.4 * b, 0.1 * opening])
    slope[:, 1] = np.column_stack([0.0 * a, 0.0 * a + 1.0, 0.4 * a, 0.0 * a])
    slope[:, 2, 3] = 0.1 * a
    combination = np.linalg.lstsq(made_up, modal.coordinates[~snapshots.held_out], rcond=None)[0]
    np.testing.assert_allclose(modal.derivatives, slope @ combination, atol=1e-4 * np.abs(modal.derivatives).max())


def test_without_derivatives_there_are_none_in_the_modes():
    snapshots, _ = made_up_snapshots(20, 5)
    assert project(replace(snapshots, derivatives=None), 4).derivatives is None


def test_nodes_count_by_what_they_carry_of_the_visible_surface_and_by_their_volume():
    snapshots, _ = made_up_snapshots(20, 5)
    carried = np.asarray(snapshots.surface.weights.sum(axis=0)).ravel() / 40  # 40 vertices, weights add up to 1
    volume = snapshots.nodal_volumes / snapshots.nodal_volumes.sum()
    expected = VISIBLE_SHARE * carried + (1 - VISIBLE_SHARE) * volume
    np.testing.assert_allclose(visible_measure(snapshots), expected, rtol=1e-12)


def test_the_first_mode_is_what_is_seen_most_though_more_tissue_moves_where_nothing_is_seen():
    snapshots, _ = made_up_snapshots(20, 5)
    seen = np.flatnonzero(visible_measure(snapshots) > 0.01)
    hidden = np.flatnonzero(np.asarray(snapshots.surface.weights.sum(axis=0)).ravel() == 0)
    displacements = np.zeros_like(snapshots.displacements)
    displacements[::2, seen, 0] = 1e-3
    displacements[1::2, hidden, 1] = 5e-3
    still = {"displacements": displacements, "derivatives": None, "lift_fields": 0 * snapshots.lift_fields}
    (mode,) = project(replace(snapshots, **still), 1).modes
    assert np.abs(mode[seen, 0]).min() > 1e6 * np.abs(mode[hidden]).max()


def test_directional_derivatives_go_a_step_up_or_down_in_every_parameter():
    snapshots, _ = made_up_snapshots(20, 5)
    rows = np.flatnonzero(~snapshots.held_out)
    derivatives = snapshots.derivatives.copy()
    derivatives[:, [0, 2, 3, 4]] = 0.0
    rigid = replace(snapshots, derivatives=derivatives, lift_fields=0 * snapshots.lift_fields)
    found = directional_derivatives(rigid, rows).reshape(len(rows), -1, 60, 3)
    each = MOST_NEIGHBOURS // len(rows)
    assert found.shape[1] == each
    size = np.abs(derivatives[rows, 1])[:, None] * STEP / np.sqrt(each)
    np.testing.assert_allclose(np.abs(found), np.broadcast_to(size, found.shape), rtol=1e-5)
    assert (found[0] != found[0, 0]).any()


def test_modes_span_directions_in_which_no_snapshot_went():
    snapshots, _ = made_up_snapshots(20, 5)
    new = np.zeros((60, 3))
    new[:, 2] = np.random.default_rng(3).normal(size=60) * 1e-3
    derivatives = snapshots.derivatives.copy()
    derivatives[:, 0] += new
    modes = project(replace(snapshots, derivatives=derivatives.astype(np.float32)), 8).modes.reshape(-1, 180)
    missed = new.ravel() - np.linalg.lstsq(modes.T, new.ravel(), rcond=None)[0] @ modes
    assert np.linalg.norm(missed) < 1e-4 * np.linalg.norm(new)
