"""AU18 of the built-in head: the mouth gets narrow and comes forward."""

import numpy as np
import pytest

from risorius_offline.contact_choice import ContactChoice
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.equilibrium import EquilibriumSolver
from tests.offline.head_measures import LEVELS, level, openings

NARROWER = 0.15  # of the mouth's width, as lip puckers of adults are at least


@pytest.fixture(scope="module")
def pucker(adult_head):
    solver = EquilibriumSolver(EffectChoice(ContactChoice.LIPS).model(adult_head))
    return solver.solve(adult_head.inputs.to_parameters(adult_head.inputs.weights({"AU18": 1.0}))).u


def rims(head, u):
    """Nodes around the mouth on the skin at rest (k, 3), and their motion (k, 3)."""
    mouth = openings(head)[0]
    return level(head, LEVELS - 1)[mouth], u.reshape(LEVELS, -1, 3)[LEVELS - 1, mouth]


def test_mouth_gets_narrower(adult_head, pucker):
    rest, motion = rims(adult_head, pucker)
    assert np.ptp((rest + motion)[:, 0]) < (1.0 - NARROWER) * np.ptp(rest[:, 0])


def test_both_lips_come_forward(adult_head, pucker):
    rest, motion = rims(adult_head, pucker)
    middle = np.abs(rest[:, 0]) < 5e-3
    assert motion[middle, 2].min() > 2e-3
