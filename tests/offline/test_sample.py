"""How a sample is tried: from a guess, from the nearest equilibrium, from rest, from rest in small steps."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from risorius.errors import SolverError
from risorius.mechanics.material import Yeoh
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel
from risorius_offline.sample import SMALL_STEPS, SampleSolver, State
from tests.offline.models import muscle_block


@dataclass
class Reluctant:
    """A solver that fails the first times it is asked, and tells from where to where."""

    solver: EquilibriumSolver
    failures: int
    asked: list[tuple[float, float]] = field(default_factory=list)

    @property
    def model(self):
        return self.solver.model

    def rest(self):
        return self.solver.rest()

    def solve(self, parameters, start):
        self.asked.append((float(start.parameters[0]), float(parameters[0])))
        if len(self.asked) <= self.failures:
            raise SolverError(f"attempt {len(self.asked)} failed")
        return self.solver.solve(parameters, start)


@dataclass
class Guessing(Reluctant):
    """Such a solver that also takes guesses: of no use, or as good as the solution."""

    useless: bool = False

    def settle(self, parameters, guess):
        if self.useless:
            raise SolverError("the guess is useless")
        return self.solver.settle(parameters, guess)


@pytest.fixture(scope="module")
def exact():
    return EquilibriumSolver(FullModel(muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3))))


@pytest.fixture(scope="module")
def states(exact):
    return [State(p, exact.solve(p).u.astype(np.float32)) for p in (np.array([0.2]), np.array([0.9]))]


SMALL = [(k / SMALL_STEPS * 0.8, (k + 1) / SMALL_STEPS * 0.8) for k in range(SMALL_STEPS)]


@pytest.mark.parametrize("failures", [0, 1, 2])
def test_a_sample_is_tried_from_the_nearest_then_from_rest_then_in_small_steps(failures, exact, states):
    solver = Reluctant(exact, failures)
    outcome = SampleSolver(solver, derivatives=True).solve(np.array([0.8]), None, states)
    wanted = [[(0.9, 0.8)], [(0.0, 0.8)], SMALL]
    np.testing.assert_allclose(solver.asked, [step for attempt in wanted[: failures + 1] for step in attempt])
    assert outcome.report["attempts"] == failures + 1
    found = exact.solve(np.array([0.8])).u
    np.testing.assert_allclose(outcome.solved.displacement, found, atol=1e-5 * np.abs(found).max())


@pytest.mark.parametrize("useless", [False, True])
def test_a_guess_is_tried_first_and_the_nearest_equilibrium_where_it_is_useless(useless, exact, states):
    solver = Guessing(exact, 0, useless=useless)
    outcome = SampleSolver(solver, derivatives=False).solve(np.array([0.8]), states[1].displacement, states)
    assert outcome.report["attempts"] == 1 + useless
    assert solver.asked == [(0.9, 0.8)] * useless
    found = exact.solve(np.array([0.8])).u
    np.testing.assert_allclose(outcome.solved.displacement, found, atol=1e-5 * np.abs(found).max())


def test_a_sample_that_cannot_be_solved_says_why_and_does_not_raise(exact, states):
    outcome = SampleSolver(Reluctant(exact, 100), derivatives=True).solve(np.array([0.8]), None, states)
    assert outcome.solved is None
    assert outcome.state is None
    assert outcome.failure == "attempt 3 failed"


def test_derivatives_are_left_out_where_they_are_not_asked_for(exact):
    outcome = SampleSolver(exact, derivatives=False).solve(np.array([0.8]), None, [])
    assert outcome.solved.fields.keys() == {"displacements"}
