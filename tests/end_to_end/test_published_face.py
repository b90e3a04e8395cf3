"""The published face: single actions of the full model move what anatomy says they move, and nothing folds."""

from __future__ import annotations

import numpy as np
import pytest

from risorius_offline.anatomy import Anatomy
from risorius_offline.equilibrium import Equilibrium, EquilibriumSolver
from risorius_offline.full_model import FullModel
from risorius_offline.jacobian_bounds import jacobian_bounds

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def face(published_face: Anatomy) -> FullModel:
    return FullModel(published_face)


def act(face: FullModel, **weights: float) -> Equilibrium:
    inputs = face.anatomy.inputs
    found = EquilibriumSolver(face).solve(inputs.to_parameters(inputs.weights(weights)))
    assert found.report.converged
    assert jacobian_bounds(face.discretisation, found.u).positive
    # Every quadrature point of the volume, and every triangle of the skin.
    jacobians = face.point_jacobians(found.u)
    assert len(jacobians) == 8 * 6024 + 6 * 318 + len(face.anatomy.skin)
    assert jacobians.min() > 0
    return found


def mouth_corners(anatomy: Anatomy) -> list[int]:
    """Skin nodes nearest to where the marginal orbicularis oris turns at either side (left, right)."""
    skin = np.unique(anatomy.skin)
    muscles = [m for m in anatomy.muscles if m.name.startswith("orbicularis_oris_marginalis")]
    turns = [muscle.fibres.lines[0][-1] for muscle in muscles]
    return [int(skin[np.linalg.norm(anatomy.points[skin] - turn, axis=1).argmin()]) for turn in turns]


def test_zygomaticus_pulls_both_mouth_corners_up_and_outwards(face: FullModel) -> None:
    u = act(face, AU12=1.0).u
    for corner, outwards in zip(mouth_corners(face.anatomy), (1.0, -1.0), strict=True):
        assert 4e-3 <= np.linalg.norm(u[corner]) <= 15e-3
        assert u[corner, 1] > 1e-3
        assert u[corner, 0] * outwards > 1e-3


def test_zygomaticus_of_one_side_leaves_the_other_side_alone(face: FullModel) -> None:
    u = act(face, AU12_L=1.0).u
    left, right = mouth_corners(face.anatomy)
    assert np.linalg.norm(u[right]) < 0.25 * np.linalg.norm(u[left])


def test_mentalis_raises_the_chin(face: FullModel) -> None:
    anatomy = face.anatomy
    u = act(face, AU17=1.0).u
    mental = np.concatenate([m.fibres.lines[0] for m in anatomy.muscles if m.name.startswith("mentalis")])
    boss = mental[mental[:, 2].argmax()]
    skin = np.unique(anatomy.skin)
    near = skin[np.linalg.norm(anatomy.points[skin] - boss, axis=1) < 8e-3]
    assert u[near, 1].mean() > 1e-3


def test_jaw_drop_carries_the_chin_down_with_the_bone(face: FullModel) -> None:
    anatomy = face.anatomy
    found = act(face, AU26=1.0)
    motion = anatomy.jaw_motion
    assert motion is not None
    expected = np.tensordot(
        motion.lift_coordinates(found.parameters[-3:]), motion.unit_motions(anatomy.points[anatomy.jaw]), axes=1
    )
    np.testing.assert_allclose(found.u[anatomy.jaw], expected, atol=1e-12)
    assert not found.u[anatomy.skull].any()
    midline = np.unique(anatomy.skin)[np.abs(anatomy.points[np.unique(anatomy.skin), 0]) < 3e-3]
    chin = midline[anatomy.points[midline, 1] < -0.1]
    assert found.u[chin, 1].mean() < -10e-3
