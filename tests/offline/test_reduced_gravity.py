"""The gravity effect against the full model: a soft block that hangs from its base, with a muscle through it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from risorius.effects.effect import UPRIGHT, Surroundings
from risorius.effects.gravity import TOLERANCE, Gravity
from risorius.effects.leaning import LEANING
from risorius.errors import InputError
from risorius.mechanics.material import Yeoh
from risorius.part import Part
from risorius_offline.effects.gravity import gravity
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel
from risorius_offline.leaning import leaning_at_rest
from risorius_offline.sensitivities import gravity_sensitivities
from tests.offline.models import muscle_block

LYING = np.array([0.0, 0.0, -9.81])


@pytest.fixture(scope="module")
def model():
    return FullModel(muscle_block("hexahedron", Yeoh.neo_hookean(10e3, 0.45)))


@pytest.fixture(scope="module")
def effect(model):
    """Trained at nine activations besides rest; the second parameter is one that tells nothing."""
    levels = np.linspace(0.1, 0.9, 9)
    found = [EquilibriumSolver(model).solve(np.array([level])) for level in levels]
    by_gravity = np.array([gravity_sensitivities(model, one) for one in found])
    snapshots = SimpleNamespace(
        parameters=np.column_stack([levels, 0.1 * np.cos(40.0 * levels)]),
        held_out=np.zeros(9, bool),
        by_gravity=by_gravity,
        displacements=np.array([one.u for one in found]),
        leaning=leaning_at_rest(model),
        surface=model.anatomy.visible_surface,
    )
    return Gravity.train(snapshots, np.zeros((0, len(model.anatomy.points), 3)))


def answer(effect, activation, towards):
    own = np.empty(len(effect.fields))
    parameters = np.array([activation, 0.0][: effect._states.shape[1]])
    effect.respond(parameters, np.zeros(0), own, Surroundings(gravity=towards))
    return np.tensordot(own, effect.fields, axes=1)


@pytest.mark.parametrize("pose", LEANING)
def test_at_rest_it_moves_the_skin_as_weight_does_in_the_full_model(model, effect, pose):
    weight = gravity(model.discretisation, pose, UPRIGHT)
    truth = EquilibriumSolver(FullModel(model.anatomy, [weight]), tolerance=1e-9).solve(np.array([0.0])).u
    carriers = np.unique(model.anatomy.visible_surface.weights.indices)
    error = np.linalg.norm(answer(effect, 0.0, pose) - truth[carriers]) / np.linalg.norm(truth[carriers])
    assert error < 0.01


@pytest.mark.parametrize(("activation", "tolerance"), [(0.25, 0.05), (0.65, 0.05)])
@pytest.mark.parametrize("leaning", [LYING, -UPRIGHT, np.array([9.81, 0.0, 0.0])])
def test_it_moves_the_skin_as_weight_does_in_the_full_model(model, effect, activation, tolerance, leaning):
    """For a small change, in which the full model is linear, too."""
    towards = UPRIGHT + 0.05 * (leaning - UPRIGHT)
    weight = gravity(model.discretisation, towards, UPRIGHT)
    solvers = [EquilibriumSolver(each, tolerance=1e-9) for each in (FullModel(model.anatomy, [weight]), model)]
    pulled, upright = (solver.solve(np.array([activation])).u for solver in solvers)
    carriers = np.unique(model.anatomy.visible_surface.weights.indices)
    truth = (pulled - upright)[carriers]
    error = np.linalg.norm(answer(effect, activation, towards) - truth) / np.linalg.norm(truth)
    assert error < tolerance


def test_upright_changes_nothing(effect):
    assert not answer(effect, 0.5, None).any()
    assert not answer(effect, 0.5, UPRIGHT).any()


def test_without_a_parameter_it_is_as_where_that_is_zero(effect):
    numbers = np.arange(effect.fields.shape[1])
    none = np.zeros(0, dtype=np.int64)
    part = Part(np.array([0]), np.array([True]), none, none, numbers, numbers, 0)
    np.testing.assert_allclose(answer(effect.within(part), 0.4, LYING), answer(effect, 0.4, LYING), atol=TOLERANCE)


def test_what_is_no_gravity_is_refused(effect):
    with pytest.raises(InputError, match=r"gravity .* m/s2; give one of at most 30"):
        effect.check(Surroundings(gravity=np.array([0.0, 40.0, 0.0])))
