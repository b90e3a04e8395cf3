"""A slender bar whose ends are pushed together: straight below the load at which it buckles, bent beyond.

And a node on a saddle that lies within the tolerance of the forces: its way down is one-sided.
"""

from dataclasses import replace

import numpy as np
import pytest

from risorius.jaw import JawMotion
from risorius.mechanics.material import Yeoh
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel
from risorius_offline.linear_solver import NotPositiveDefiniteError
from risorius_offline.newton import GuardedNewton, SolverReport
from risorius_offline.stability import way_down
from risorius_offline.tangents import Tangents
from tests.offline.meshes import box
from tests.offline.models import block_anatomy

THICKNESS, LENGTH = 0.01, 0.06
# Euler's strain of a column that is clamped at both ends, 4 pi^2 I / (A l^2).
EULER = 4.0 * np.pi**2 * (THICKNESS**2 / 12.0) / LENGTH**2


@pytest.fixture(scope="module")
def model():
    """jaw_forward = 1 shortens the bar by twice Euler's strain."""
    points, block = box("hexahedron", (2, 2, 8), (THICKNESS, THICKNESS, LENGTH))
    anatomy = block_anatomy(points, block, Yeoh.neo_hookean(15e3, 0.3), dragged=np.isclose(points[:, 2], LENGTH))
    motion = JawMotion((0.0, 0.0, 0.0), 0.0, 0.0, -2.0 * EULER * LENGTH, 0.0)
    return FullModel(replace(anatomy, jaw_motion=motion))


def pushed(weight):
    return np.array([0.0, weight, 0.0])


def straight(model, weight):
    """What Newton's method alone makes of the symmetric problem."""
    model.set_parameters(pushed(weight))
    guess = model.follow_bones(np.zeros_like(model.anatomy.points), pushed(0.0), pushed(weight))
    return GuardedNewton(1e-9, 80).minimise(model, guess, SolverReport())


def bend(model, u):
    """How far the middle of the bar has gone sideways, metres."""
    middle = np.isclose(model.anatomy.points[:, 2], 0.5 * LENGTH)
    return float(np.linalg.norm(u[middle, :2].mean(axis=0)))


def test_below_the_load_of_buckling_the_straight_bar_is_a_minimum(model):
    u, report = straight(model, 0.25), SolverReport()
    assert way_down(model, u, report) is None
    assert report.stable
    assert bend(model, EquilibriumSolver(model).solve(pushed(0.25)).u) < 1e-6


def test_beyond_it_there_is_a_way_down_from_the_straight_bar(model):
    u, report = straight(model, 1.0), SolverReport()
    lower = way_down(model, u, report)
    assert bend(model, u) < 1e-6
    assert not report.stable
    assert model.energy(lower) < model.energy(u)
    np.testing.assert_array_equal(lower.ravel()[model.prescribed], u.ravel()[model.prescribed])


def test_the_solver_goes_on_to_the_bent_bar_which_is_a_minimum(model):
    """The middle of an inextensible one goes aside by 2 l / pi times the root of the strain beyond Euler's."""
    found = EquilibriumSolver(model).solve(pushed(1.0))
    assert found.report.converged
    assert found.report.stable
    assert found.report.energy < model.energy(straight(model, 1.0))
    assert bend(model, found.u) == pytest.approx(2.0 * LENGTH / np.pi * np.sqrt(EULER), rel=0.1)


class TiltedWell:
    """One node with the energy tilt x - c x^2 / 2 + b x^4 / 4 + k (y^2 + z^2) / 2.

    A tilt above 2 c / 3 sqrt(c / (3 b)) leaves one minimum, at the real root of b x^3 - c x + tilt.
    """

    C, B, K = 0.03, 2e8, 1.0
    free, energy_scale = np.arange(3), 1e-6

    def __init__(self, tilt):
        self.tilt = tilt

    def energy(self, u):
        return self.forces(u)[0]

    def forces(self, u):
        (x, y, z), c, b, k = u[0], self.C, self.B, self.K
        value = self.tilt * x - c * x**2 / 2 + b * x**4 / 4 + k * (y**2 + z**2) / 2
        return value, 1.0, np.array([[self.tilt - c * x + b * x**3, k * y, k * z]])

    def tangents(self, u):
        along = -self.C + 3.0 * self.B * u[0, 0] ** 2
        none = (np.zeros(3), [])
        return Tangents(lambda _: none, lambda project: np.array([abs(along) if project else along, self.K, self.K]))

    def factorise(self, values, _, *, rough=False):
        if values.min() <= 0.0:
            raise NotPositiveDefiniteError("not a minimum")
        self.factors = values

    def solve(self, right_hand_side):
        return (right_hand_side.T / self.factors).T

    def largest_step(self, u, direction):
        return 1.0


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_way_down_from_a_saddle_within_the_tolerance_ends_where_there_is_a_minimum(side):
    c, b = TiltedWell.C, TiltedWell.B
    well = TiltedWell(side * c * np.sqrt(c / (3.0 * b)))
    (minimum,) = (root.real for root in np.roots([b, 0.0, -c, well.tilt]) if abs(root.imag) < 1e-9)
    u, report = np.zeros((1, 3)), SolverReport()
    lower = way_down(well, u, report)
    assert not report.stable
    assert abs(lower[0, 0] - minimum) < 0.5 * abs(minimum)
    assert way_down(well, lower, report) is None
    assert report.stable
