"""The touch effect against the full model: a block that is pushed at a corner of its top."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from risorius.effects.effect import Surroundings, Touch
from risorius.effects.touch import TouchResponse
from risorius.mechanics.material import Yeoh
from risorius_offline.body import body_of
from risorius_offline.effects import DeadLoad
from risorius_offline.effects.bone_contact import BoneContact
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel
from risorius_offline.one_sided import springs_at_rest
from tests.offline.models import muscle_block
from tests.offline.test_bone_contact import box_surface

BLOCK = muscle_block("hexahedron", Yeoh.neo_hookean(10e3, 0.45))
BESIDE_BONE = replace(BLOCK, bones={"maxilla": box_surface([0.0202, -0.05, -0.05], [0.05, 0.05, 0.05])})
CORNER = int(BLOCK.visible_surface.points.sum(axis=1).argmax())


def moved(anatomy, contact, force):
    """Displacement (n, 3) of the visible vertices by a force on the corner, in the effect and in the full model."""
    model, surface = FullModel(anatomy, contact), anatomy.visible_surface
    snapshots = SimpleNamespace(
        body=body_of(model),
        surface=surface,
        points=anatomy.points,
        muscles=("pull",),
        contact=contact or None,
        springs=springs_at_rest(model),
    )
    effect = TouchResponse.train(snapshots, np.zeros((0, len(anatomy.points), 3)))
    touches = Surroundings(touches=(Touch(CORNER, force),))
    effect.check(touches)
    effect.respond(np.zeros(1), np.zeros(0), np.zeros(0), touches)
    vertices = np.zeros(surface.points.shape, np.float32)
    effect.finish(np.zeros(0), vertices)
    nodal = surface.weights.T @ np.eye(len(surface.points))[:, [CORNER]] * force
    loaded = FullModel(anatomy, [*contact, DeadLoad(nodal)])
    return vertices, surface.weights @ EquilibriumSolver(loaded, 1e-9).solve(np.zeros(1)).u


@pytest.mark.parametrize("force", [(0.0, 0.0, -1e-3), (1e-3, 0.0, 0.0), (5e-4, -1e-3, 5e-4)])
def test_a_light_touch_moves_the_skin_as_in_the_full_model(force):
    vertices, truth = moved(BLOCK, [], force)
    np.testing.assert_allclose(vertices, truth, atol=0.01 * np.abs(truth).max())


@pytest.mark.parametrize("force", [(1e-2, 0.0, 0.0), (3e-2, 0.0, 0.0), (-1e-2, 0.0, 0.0)])
def test_a_bone_stops_a_touch_as_in_the_full_model_and_does_not_hold_what_leaves_it(force):
    """The block lies 0.2 mm off a bone, where contact begins at once; what it moves is small enough to be linear."""
    contact = [BoneContact(BESIDE_BONE)]
    vertices, truth = moved(BESIDE_BONE, contact, force)
    np.testing.assert_allclose(vertices, truth, atol=0.05 * np.abs(truth).max())
    free = moved(BLOCK, [], force)[1]
    stopped = np.abs(truth).max() < 0.5 * np.abs(free).max()
    assert stopped == (force[0] > 0.0)
