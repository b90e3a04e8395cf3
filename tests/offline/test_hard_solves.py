"""Hard solves of an anatomy of the user's."""

from dataclasses import replace

import numpy as np
import pytest

from risorius.gauntlet.full_model import TOLERANCE
from risorius_offline.equilibrium import EquilibriumSolver, NotConvergedError
from risorius_offline.hard_solves import attempt, cases
from tests.offline.hard_models import slab


@pytest.mark.parametrize("case", [pytest.param(case, id=case.name) for case in cases(slab("wedge"))])
def test_a_slab_of_four_layers_comes_to_an_equilibrium(case):
    solved = attempt(case)
    assert not solved.refused
    assert solved.finite
    assert solved.smallest_jacobian > 0.0
    assert solved.residual <= TOLERANCE
    assert (solved.farthest > 1e-6) == (case.parameters.max() > 1e-300)


def test_layers_are_a_thousand_times_as_stiff():
    anatomy = slab("wedge")
    made = {case.name: case.anatomy for case in cases(anatomy)}["odd layers 1000 times stiffer"]
    ratios = [ours.c10 / theirs.c10 for ours, theirs in zip(made.materials, anatomy.materials, strict=True)]
    np.testing.assert_allclose(ratios, [1.0, 1000.0, 1.0, 1000.0])


def test_what_is_refused_says_why(monkeypatch):
    def refuse(solver, parameters, start=None):
        raise NotConvergedError("no equilibrium beyond 0.3", None)

    monkeypatch.setattr(EquilibriumSolver, "solve", refuse)
    assert attempt(replace(cases(slab())[0])).refused == "no equilibrium beyond 0.3"
