"""A slender bar whose ends are pushed together: straight below the load at which it buckles, bent beyond."""

from dataclasses import replace

import numpy as np
import pytest

from risorius.jaw import JawMotion
from risorius.mechanics.material import Yeoh
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel
from risorius_offline.newton import GuardedNewton, SolverReport
from risorius_offline.stability import way_down
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
