"""Prescribed motions: the upper lids' own, and how they share one vector of weights with the mandible's."""

import h5py
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from risorius.inputs import InputTable
from risorius.jaw import JawMotion
from risorius.lids import LidMotion
from risorius.poses import POSE_LOWER, Poses

JAW = JawMotion((0.0, -0.03, -0.09), 0.5, 0.008, 0.005, 0.01)
LIDS = LidMotion(((0.031, -0.004, -0.012), (-0.033, -0.005, -0.013)), closing_angle=0.8)


@pytest.mark.parametrize("weights", [(0.0, 0.0), (1.0, 0.0), (-0.4, 0.7)])
def test_each_lid_turns_rigidly_about_its_own_eyeball(weights):
    points = np.random.default_rng(0).normal(size=(50, 3)) * 0.02
    coordinates, motions = LIDS.lift_coordinates(weights), LIDS.unit_motions(points)
    for side, rows in enumerate((slice(0, 2), slice(2, 4))):
        centre = np.array(LIDS.centres[side])
        turned = Rotation.from_rotvec([0.8 * weights[side], 0.0, 0.0]).apply(points - centre) + centre
        found = np.tensordot(coordinates[rows], motions[rows], axes=1)
        np.testing.assert_allclose(found, turned - points, atol=1e-16)


def test_closing_takes_the_margin_of_the_lid_down():
    margin = np.add(LIDS.centres[0], [[0.0, 0.005, 0.012]])
    moved = np.tensordot(LIDS.lift_coordinates((1.0, 0.0)), LIDS.unit_motions(margin), axes=1)[0]
    assert moved[1] < -0.008
    assert moved[0] == 0.0


@pytest.mark.parametrize(
    ("poses", "inputs"),
    [
        (Poses(), ()),
        (Poses(lids=LIDS), LIDS.inputs),
        (Poses(JAW, LIDS), (*JAW.inputs, *LIDS.inputs)),
    ],
)
def test_weights_of_all_motions_follow_one_another(poses, inputs):
    assert poses.inputs == inputs
    weights = np.linspace(-0.5, 1.0, len(inputs))
    split = len(JAW.inputs) if poses.jaw else 0
    expected = [JAW.lift_coordinates(weights[:split])] if poses.jaw else []
    expected += [LIDS.lift_coordinates(weights[split:])] if poses.lids else []
    np.testing.assert_array_equal(poses.lift_coordinates(weights), np.concatenate([np.zeros(0), *expected]))
    assert poses.lift_count == sum(map(len, expected))


@pytest.mark.parametrize("poses", [Poses(JAW), Poses(lids=LIDS), Poses(JAW, LIDS)])
def test_slopes_of_the_lift_coordinates_are_their_derivatives(poses):
    weights, step = np.linspace(-0.5, 0.9, len(poses.inputs)), 1e-6
    lift = poses.lift_coordinates
    numeric = [(lift(weights + e) - lift(weights - e)) / (2.0 * step) for e in step * np.eye(len(weights))]
    np.testing.assert_allclose(poses.lift_slopes(weights), numeric, atol=1e-9)


@pytest.mark.parametrize("poses", [Poses(), Poses(JAW), Poses(lids=LIDS), Poses(JAW, LIDS)])
def test_poses_come_back_from_a_file_as_they_were(poses, tmp_path):
    with h5py.File(tmp_path / "poses.h5", "w") as file:
        poses.write(file)
        assert Poses.read(file) == poses


def test_every_pose_input_has_a_range():
    assert set(Poses(JAW, LIDS).inputs) == set(POSE_LOWER)


def test_a_lid_opens_a_third_as_far_as_it_closes_and_has_two_sides():
    table = InputTable(("zygomaticus_major_L", "zygomaticus_major_R"), Poses(JAW, LIDS).inputs)
    parameters = table.to_parameters(table.weights({"upper_lid": -0.3, "AU12_L": 0.3, "jaw_open": 0.2}))
    np.testing.assert_array_equal(parameters, [0.3, 0.0, 0.2, 0.0, 0.0, -0.3, -0.3])
    np.testing.assert_array_equal(table.parameter_lower, [0.0, 0.0, 0.0, -1.0, -1.0, -0.3, -0.3])
    one = table.to_parameters(table.weights({"upper_lid_R": 0.7}))
    np.testing.assert_array_equal(one[-2:], [0.0, 0.7])
