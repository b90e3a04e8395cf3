"""The gauntlet passes what holds, fails what does not, and never passes what a model lacks."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from risorius import commands
from risorius.cli import app
from risorius.effects.inertia import Inertia
from risorius.effects.strain_lag import StrainLag
from risorius.effects.vibrations import Vibrations
from risorius.gauntlet import all_cases, run
from risorius.gauntlet.case import Bench
from risorius.gauntlet.full_model import HardSolved, as_result
from risorius.gauntlet.run import FAILED, NOT_APPLICABLE, PASSED
from risorius.guard import Guard, Verdict, Watch
from risorius.penetration import Penetration


@pytest.fixture(scope="module")
def watched_model(synthetic_model):
    """Tissue folds where a modal coordinate comes to 0.9."""
    gradients = np.zeros((synthetic_model.rank, 6, 9), np.float32)
    gradients[synthetic_model.lifts + np.arange(6), np.arange(6), 0] = -1.0 / 0.9
    return replace(synthetic_model, watch=Watch(gradients, longest=3.0))


def results(model, group=None):
    return list(run(model, [case for case in all_cases() if group in (None, case.group)]))


def test_there_are_over_a_hundred_cases_and_each_has_a_name_of_its_own():
    cases = all_cases()
    assert len({case.name for case in cases}) == len(cases) > 100


def test_every_case_of_a_sound_model_passes_or_does_not_apply(watched_model):
    found = results(watched_model)
    assert [one for one in found if one.outcome == FAILED] == []
    assert sum(one.outcome == PASSED for one in found) > 80
    assert sum(one.mended for one in found) > 0
    assert all(one.smallest_jacobian > 0.0 for one in found if one.frames)


@pytest.mark.parametrize("group", ["inertia", "gravity", "touch", "contact"])
def test_effects_that_a_model_lacks_are_not_applicable(synthetic_model, group):
    found = results(synthetic_model, group)
    assert found
    assert {(one.outcome, one.detail) for one in found} == {(NOT_APPLICABLE, f"no effect {group}")}


def test_actions_that_a_model_lacks_are_not_applicable(synthetic_model):
    found = {one.name: one for one in results(synthetic_model, "extremes")}
    assert (found["AU1"].outcome, found["AU1"].detail) == (NOT_APPLICABLE, "no input AU1")
    assert found["AU12"].outcome == PASSED


def broken(model, group):
    failed = [one.detail for one in results(model, group) if one.outcome == FAILED]
    return {word.split(":")[0] for detail in failed for word in detail.split(", ")}


def test_folded_frames_fail_without_the_guard(watched_model, monkeypatch):
    monkeypatch.setattr(Guard, "settle", lambda guard, coordinates: Verdict.GOOD)
    assert broken(watched_model, "extremes") == {"unfolded"}


class Growing(Inertia):
    """Vibration that is pushed by nothing, and grows."""

    def respond(self, parameters, coordinates, own, surroundings):
        super().respond(parameters, coordinates, own, surroundings)
        self._vibrations._speed += 1e-3

    def at(self, setting):
        still = super().at(setting)
        return Growing(still.fields, still._vibrations, still._static, still._lifts, still._strain_lag)


@pytest.mark.parametrize(("kind", "verdicts"), [(Inertia, set()), (Growing, {"energy"})])
def test_motion_that_gains_energy_fails(synthetic_model, kind, verdicts):
    rng = np.random.default_rng(0)
    fields = 1e-4 * rng.normal(size=(4, len(synthetic_model.rest_vertices), 3)).astype(np.float32)
    static = 1e-2 * rng.normal(size=(4, synthetic_model.rank))
    squares, modes = np.array([2e2, 1e3, 1e4, 1e5]), synthetic_model.rank - synthetic_model.lifts
    strain_lag = StrainLag(1e-2 * rng.normal(size=(2, modes)), np.array([0.03, 0.05]))
    inertia = kind(fields, Vibrations(squares, 19.0 + 0.055 * squares), static, synthetic_model.lifts, strain_lag)
    assert broken(replace(synthetic_model, effects={"inertia": inertia}), "inertia") == verdicts


@pytest.mark.parametrize(("depth", "verdicts"), [(0.2e-3, set()), (0.4e-3, {"penetration"})])
def test_skin_in_teeth_fails(synthetic_model, monkeypatch, depth, verdicts):
    monkeypatch.setattr(Bench, "penetration", staticmethod(lambda vertices, coordinates: Penetration(depth, 0.0)))
    assert broken(synthetic_model, "sequences") == verdicts


class Exploding:
    """The polynomial, but for full activation."""

    name, doubt = "polynomial", 0.0

    def __init__(self, inner, value):
        self.inner, self.value = inner, value

    def coordinates(self, parameters, out):
        self.inner.coordinates(parameters, out)
        if parameters.max() == 1.0:
            out[:] = self.value

    def at(self, setting):
        return Exploding(self.inner.at(setting), self.value)


@pytest.mark.parametrize(("value", "verdicts"), [(np.nan, {"finite", "bounded"}), (1e3, {"bounded"})])
def test_explosions_fail_without_the_guard_and_are_held_with_it(watched_model, monkeypatch, value, verdicts):
    exploding = Exploding(watched_model.evaluators["polynomial"], value)
    watch = replace(watched_model.watch, gradients=0.0 * watched_model.watch.gradients, longest=1.0)
    model = replace(watched_model, evaluators={**watched_model.evaluators, "polynomial": exploding}, watch=watch)
    guarded = results(model, "sequences")
    assert {one.outcome for one in guarded} <= {PASSED, NOT_APPLICABLE}
    assert sum(one.held for one in guarded) > 0
    monkeypatch.setattr(Guard, "settle", lambda guard, coordinates: Verdict.GOOD)
    assert broken(model, "sequences") == verdicts


def test_the_command_prints_every_case_and_fails_where_one_does(model_file, monkeypatch):
    commands.register(app)
    whole = CliRunner().invoke(app, ["gauntlet", str(model_file), "--json"])
    assert whole.exit_code == 0
    content = json.loads(whole.stdout)
    assert len(content["cases"]) == len(all_cases())
    assert {one["outcome"] for one in content["cases"]} == {PASSED, NOT_APPLICABLE}
    monkeypatch.setattr("risorius.gauntlet.judge.SAME", -1.0)
    failed = CliRunner().invoke(app, ["gauntlet", str(model_file)])
    assert "gauntlet" in str(failed.exception)
    assert "failed" in failed.stdout


@pytest.mark.parametrize(
    ("solved", "outcome", "detail"),
    [
        (HardSolved("a", smallest_jacobian=0.1, residual=1e-8), PASSED, ""),
        (HardSolved("a", smallest_jacobian=-0.1, residual=1e-8), FAILED, "folded"),
        (HardSolved("a", smallest_jacobian=0.1, residual=1e-3), FAILED, "residual 1.0e-03"),
        (HardSolved("a", finite=False, residual=np.nan), FAILED, "not finite, residual nan"),
        (HardSolved("a", refused="no equilibrium beyond 0.3"), PASSED, "refused: no equilibrium beyond 0.3"),
    ],
)
def test_a_hard_solve_passes_with_an_equilibrium_or_a_reason(solved, outcome, detail):
    result = as_result(solved)
    assert (result.outcome, result.detail) == (outcome, detail)
