"""The inertia effect against the motion of the full model: a bar that a muscle bends, a sheet that one strains."""

from __future__ import annotations

import numpy as np

from risorius.effects.effect import Surroundings
from risorius.effects.inertia import Inertia
from risorius.effects.lag import lag
from risorius.effects.strain_lag import StrainedBody, StrainLag
from risorius.effects.vibrations import Vibrations, vibration_modes
from risorius.mechanics.material import STIFFNESS_DAMPING, TISSUE_DENSITY, Yeoh
from risorius_offline.body import body_of
from risorius_offline.dynamics import MotionSolver
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel
from risorius_offline.muscles.loads import ActiveStress
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.polyline_fibres import PolylineFibres
from tests.offline.meshes import box
from tests.offline.models import block_anatomy


class Moving:
    """A model of one muscle."""

    def __init__(self, cells, size, line, radius, stress):
        points, connectivity = box("hexahedron", cells=cells, size=size)
        muscle = Muscle("only", PolylineFibres((np.array(line),), radius), ActiveStress(stress))
        tissue = Yeoh.neo_hookean(15e3, 0.45)
        self.model = FullModel(block_anatomy(points, connectivity, tissue, muscles=(muscle,)))
        self.volumes, self.body = self.model.discretisation.nodal_volumes, body_of(self.model)
        self.modes, *self.vibrations = vibration_modes(self.body, self.volumes)

    def still(self, activation):
        return EquilibriumSolver(self.model, tolerance=1e-9).solve(np.array([activation])).u

    def truth(self, activations, step):
        states = MotionSolver(self.model).simulate(activations[:, None], step)
        return np.array([state.u for state in states])

    def follow(self, activations, step):
        """Displacements (t, n, 3): equilibria under loads that lag with vibrations about them, and without these."""
        count = len(self.modes)
        vibrations, strain_lag = Vibrations(*self.vibrations), StrainLag.none(1, count)
        inertia = Inertia(np.zeros((count, 1, 3), np.float32), vibrations, np.eye(count), 0, strain_lag)
        masses, moving, still = TISSUE_DENSITY * self.volumes[:, None], [], []
        for activation in activations:
            driven, own = np.array([activation]), np.empty(count)
            inertia.drive(driven, Surroundings(step))
            u = self.still(driven[0])
            inertia.respond(driven, np.tensordot(self.modes * masses, u, axes=2), own, Surroundings(step))
            still.append(u)
            moving.append(u + np.tensordot(own, self.modes, axes=1))
        return np.array(moving), np.array(still)


def from_rest_to(activation, steps):
    activations = np.full(steps + 1, activation)
    activations[0] = 0.0
    return activations


def largest_error(found, truth):
    """Over nodes and moments, of the largest displacement."""
    return np.linalg.norm(found - truth, axis=2).max() / np.linalg.norm(truth, axis=2).max()


def test_a_bar_that_begins_to_bend_moves_as_in_the_full_model():
    """Within 2 % of the largest displacement, all along; without mass it would be half of it."""
    bar = Moving((2, 2, 8), (0.01, 0.01, 0.06), [[0.009, 0.005, 0.0], [0.009, 0.005, 0.06]], 0.003, 20e3)
    activations = from_rest_to(0.02, 25)
    truth = bar.truth(activations, 0.02)
    errors = [largest_error(found, truth) for found in bar.follow(activations, 0.02)]
    assert errors[0] < 0.02
    assert errors[1] > 0.4


def test_tissue_that_its_muscle_strains_does_not_lag_as_the_load_does():
    """In a sheet whose muscle moves its ends by 3.4 of 24 mm, lag of strained tissue halves what is missed."""
    sheet = Moving((8, 4, 2), (0.04, 0.02, 0.006), [[0.008, 0.01, 0.004], [0.032, 0.01, 0.004]], 0.004, 20e3)
    step, activations = 0.02, from_rest_to(1.0, 15)
    slope = (sheet.still(1.0) - sheet.still(0.999)) / 0.001
    share, time = StrainedBody(sheet.body, None).lag(sheet.still(1.0), np.array([1.0]), slope)
    strain_lag = StrainLag(np.eye(1), np.array([time]))
    load, missing = np.zeros(1), np.zeros((len(activations), 1))
    for number in range(1, len(activations)):
        lag(
            step,
            np.full(1, STIFFNESS_DAMPING),
            activations[number - 1 : number],
            activations[number : number + 1],
            load,
        )
        strain_lag.add(step, load, missing[number])
    truth = sheet.truth(activations, step)
    without, _ = sheet.follow(activations, step)
    assert largest_error(without, truth) > 0.014
    assert largest_error(without + np.tensordot(missing, share[None], axes=1), truth) < 0.007
