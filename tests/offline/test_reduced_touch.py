"""The touch effect against the full model: a block that is pushed at a corner of its top."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from risorius.effects.effect import Surroundings, Touch
from risorius.effects.touch import TouchResponse
from risorius.mechanics.material import Yeoh
from risorius_offline.body import body_of
from risorius_offline.effects import DeadLoad
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel
from tests.offline.models import muscle_block


@pytest.mark.parametrize("force", [(0.0, 0.0, -1e-3), (1e-3, 0.0, 0.0), (5e-4, -1e-3, 5e-4)])
def test_a_light_touch_moves_the_skin_as_in_the_full_model(force):
    model = FullModel(muscle_block("hexahedron", Yeoh.neo_hookean(10e3, 0.45)))
    points, surface = model.anatomy.points, model.anatomy.visible_surface
    snapshots = SimpleNamespace(body=body_of(model), surface=surface, points=points, muscles=("pull",), contact=None)
    effect = TouchResponse.train(snapshots, np.zeros((0, len(points), 3)))
    vertex = int(surface.points.sum(axis=1).argmax())
    touches = Surroundings(touches=(Touch(vertex, force),))
    effect.check(touches)
    effect.respond(np.zeros(1), np.zeros(0), np.zeros(0), touches)
    vertices = np.zeros(surface.points.shape, np.float32)
    effect.finish(np.zeros(0), vertices)
    nodal = surface.weights.T @ np.eye(len(surface.points))[:, [vertex]] * force
    truth = surface.weights @ EquilibriumSolver(FullModel(model.anatomy, [DeadLoad(nodal)]), 1e-9).solve(np.zeros(1)).u
    np.testing.assert_allclose(vertices, truth, atol=0.01 * np.abs(truth).max())
