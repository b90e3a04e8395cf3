import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from risorius.jaw import JawMotion

MOTION = JawMotion(
    (0.0, -0.03, -0.09), opening_angle=0.5, opening_slide=0.008, forward_slide=0.005, sideways_slide=0.01
)


@pytest.mark.parametrize("weights", [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.6, -1.0, 0.4)])
def test_lift_coordinates_and_unit_motions_are_the_rigid_motion_exactly(weights):
    points = np.random.default_rng(0).normal(size=(50, 3)) * 0.1
    centre = np.array(MOTION.condyle_centre)
    opening, forward, sideways = weights
    turned = Rotation.from_rotvec([0.5 * opening, 0.0, 0.0]).apply(points - centre) + centre
    slide = np.array([0.01 * sideways, 0.0, 0.008 * opening + 0.005 * forward])
    found = np.tensordot(MOTION.lift_coordinates(weights), MOTION.unit_motions(points), axes=1)
    np.testing.assert_allclose(found, turned + slide - points, atol=1e-16 + 1e-15)


def test_opening_moves_the_chin_down_and_back():
    chin = np.array([[0.0, -0.12, 0.01]])
    only_turning = JawMotion(MOTION.condyle_centre, 0.5, 0.0, 0.0, 0.0)
    moved = np.tensordot(only_turning.lift_coordinates((1.0, 0.0, 0.0)), only_turning.unit_motions(chin), axes=1)[0]
    assert moved[1] < -0.03
    assert moved[2] < -0.03
