"""The inertia effect against the motion of the full model: a slender bar that a muscle at its side bends."""

from __future__ import annotations

import numpy as np
import pytest

from risorius.effects.effect import Surroundings
from risorius.effects.inertia import Inertia, vibration_modes
from risorius.mechanics.material import TISSUE_DENSITY, Yeoh
from risorius_offline.body import body_of
from risorius_offline.dynamics import MotionSolver
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel
from risorius_offline.muscles.loads import ActiveStress
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.polyline_fibres import PolylineFibres
from tests.offline.meshes import box
from tests.offline.models import block_anatomy

LENGTH = 0.06


class Bar:
    def __init__(self):
        points, cells = box("hexahedron", cells=(2, 2, 8), size=(0.01, 0.01, LENGTH))
        line = np.array([[0.009, 0.005, 0.0], [0.009, 0.005, LENGTH]])
        muscle = Muscle("side", PolylineFibres((line,), 0.003), ActiveStress(20e3))
        self.model = FullModel(block_anatomy(points, cells, Yeoh.neo_hookean(15e3, 0.45), muscles=(muscle,)))
        self.volumes = self.model.discretisation.nodal_volumes
        self.modes, self.squares = vibration_modes(body_of(self.model), self.volumes)

    def still(self, activation):
        return EquilibriumSolver(self.model, tolerance=1e-9).solve(np.array([activation])).u

    def follow(self, activations, step):
        """Displacements (t, n, 3): equilibria under loads that lag with vibrations about them, and without these."""
        count = len(self.modes)
        inertia = Inertia(np.zeros((count, 1, 3), np.float32), self.squares, np.eye(count), 0, 1)
        masses, moving, still = TISSUE_DENSITY * self.volumes[:, None], [], []
        for activation in activations:
            driven, own = np.array([activation]), np.empty(count)
            inertia.drive(driven, Surroundings(step))
            u = self.still(driven[0])
            inertia.respond(driven, np.tensordot(self.modes * masses, u, axes=2), own, Surroundings(step))
            still.append(u)
            moving.append(u + np.tensordot(own, self.modes, axes=1))
        return np.array(moving), np.array(still)


@pytest.fixture(scope="module")
def bar():
    return Bar()


def test_a_bar_that_begins_to_bend_moves_as_in_the_full_model(bar):
    """Within 2 % of the largest displacement, all along; without mass it would be half of it."""
    activations = np.full(26, 0.02)
    activations[0] = 0.0
    states = MotionSolver(bar.model).simulate(activations[:, None], 0.02)
    truth = np.array([state.u for state in states])
    peak = np.linalg.norm(truth, axis=2).max()
    errors = [np.linalg.norm(found - truth, axis=2).max() / peak for found in bar.follow(activations, 0.02)]
    assert errors[0] < 0.02
    assert errors[1] > 0.4
