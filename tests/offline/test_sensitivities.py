"""du/dp against differences of equilibria that are solved anew."""

from dataclasses import replace

import numpy as np
import pytest

from risorius.errors import SolverError
from risorius.jaw import JawMotion
from risorius.mechanics.material import Yeoh
from risorius_offline.effects.gravity import gravity
from risorius_offline.equilibrium import Equilibrium, EquilibriumSolver
from risorius_offline.full_model import FullModel
from risorius_offline.muscles.loads import ActiveStress
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.polyline_fibres import PolylineFibres
from risorius_offline.sensitivities import gravity_sensitivities, sensitivities
from tests.offline.meshes import box
from tests.offline.models import block_anatomy


@pytest.fixture(scope="module")
def model():
    """A 20 mm cube with two muscles between a fixed bottom and a top that moves as a mandible."""
    points, cells = box("hexahedron", cells=(3, 3, 3), distortion=0.15)
    lines = [np.array([[0.0, y, 0.01], [0.02, y, 0.012]]) for y in (0.006, 0.014)]
    muscles = tuple(
        Muscle(f"pull_{k}", PolylineFibres((line,), 0.004), ActiveStress(20e3)) for k, line in enumerate(lines)
    )
    top = np.isclose(points[:, 2], 0.02)
    anatomy = block_anatomy(points, cells, Yeoh(2500.0, 1175.0, 250e3), dragged=top, muscles=muscles)
    return FullModel(replace(anatomy, jaw_motion=JawMotion((0.0, 0.03, 0.0), 0.2, 0.003, 0.002, 0.002)))


STATE = np.array([0.7, 0.3, 0.6, -0.4, 0.5])


def test_they_are_the_derivatives_of_the_solved_equilibrium(model):
    solver = EquilibriumSolver(model, tolerance=1e-12)
    found = solver.solve(STATE)
    derivatives = sensitivities(model, found)
    h = 1e-4
    for number in range(len(STATE)):
        step = h * np.eye(len(STATE))[number]
        difference = (solver.solve(STATE + step, found).u - solver.solve(STATE - step, found).u) / (2 * h)
        np.testing.assert_allclose(derivatives[number], difference, atol=2e-7 * np.abs(difference).max())


def test_those_by_gravity_are_what_weight_along_each_axis_changes(model):
    found = EquilibriumSolver(model, tolerance=1e-12).solve(STATE)
    derivatives = gravity_sensitivities(model, found)
    for number, along in enumerate(np.eye(3)):
        pulled = [
            FullModel(model.anatomy, [gravity(model.discretisation, sign * along, np.zeros(3))]) for sign in (1.0, -1.0)
        ]
        ends = [EquilibriumSolver(each, tolerance=1e-12).solve(STATE, found).u for each in pulled]
        difference = 0.5 * (ends[0] - ends[1])
        np.testing.assert_allclose(derivatives[number], difference, atol=1e-5 * np.abs(difference).max())


def test_the_model_keeps_the_parameters_it_had(model):
    found = EquilibriumSolver(model, tolerance=1e-10).solve(STATE)
    before = model.forces(found.u)[2]
    sensitivities(model, found)
    np.testing.assert_array_equal(model.forces(found.u)[2], before)


def test_they_need_no_factorisation_where_the_equilibrium_has_just_been_found(model, monkeypatch):
    found = EquilibriumSolver(model).solve(STATE)
    with monkeypatch.context() as patch:
        patch.delattr(FullModel, "factorise")
        at_once = sensitivities(model, found)
    np.testing.assert_array_equal(at_once, sensitivities(model, replace(found)))


def test_they_are_of_the_equilibrium_asked_for_after_another_has_been_found(model):
    found = EquilibriumSolver(model).solve(STATE)
    expected = sensitivities(model, found)
    EquilibriumSolver(model).solve(0.5 * STATE)
    np.testing.assert_array_equal(sensitivities(model, found), expected)


def test_an_unstable_state_is_refused(model):
    u = EquilibriumSolver(model).solve(STATE).u
    squeezed = u.copy()
    squeezed[:, 0] -= 0.75 * model.anatomy.points[:, 0]  # compressed to a quarter: the tangent has negative directions
    squeezed[:, 2] -= 0.3 * model.anatomy.points[:, 2]
    with pytest.raises(SolverError, match="not stable"):
        sensitivities(model, Equilibrium(STATE, squeezed))
