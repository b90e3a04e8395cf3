"""Mirror images of a symmetric face, its modes, and derivatives in them."""

from dataclasses import replace

import numpy as np
from tests.rom.test_training import JAW, made_up_snapshots

from risorius.bases import pod
from risorius.modal import symmetric_pod
from risorius.symmetry import ACROSS, Mirror, mirror_of
from risorius.training import project, single_actions


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
    mirror = mirror_of(snapshots, single_actions(snapshots))
    assert mirror is not None
    np.testing.assert_array_equal(mirror.nodes, nodes)
    np.testing.assert_array_equal(mirror.partner, [1, 0, 2, 3, 4])
    np.testing.assert_array_equal(mirror.sign, [1, 1, 1, 1, -1])


def test_a_face_whose_sides_move_differently_is_not_symmetric():
    snapshots, _ = symmetric_snapshots()
    snapshots.displacements[0] *= 1.01
    assert mirror_of(snapshots, single_actions(snapshots)) is None


def test_a_face_whose_nodes_lie_differently_is_not_symmetric():
    snapshots, _ = symmetric_snapshots()
    snapshots.points[3] += 1e-4
    assert mirror_of(snapshots, single_actions(snapshots)) is None


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
