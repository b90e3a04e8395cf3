"""The full model in the report of a reduced one: the same anatomy, the same effects, the inputs that were asked for."""

from __future__ import annotations

import numpy as np
import pytest

from risorius.errors import InputError
from risorius.mechanics.fibres import HILL
from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy import load_source
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.timed_full_model import TimedFullModel
from tests.offline.models import muscle_block


@pytest.fixture
def source(tmp_path):
    """File and provenance of a cube of tissue whose muscle follows Hill's curve."""
    anatomy = muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3))
    anatomy.save(tmp_path / "block.h5")
    effects = EffectChoice(force_length=True)
    return str(tmp_path / "block.h5"), {"anatomy": anatomy.checksum(), **effects.provenance()}


def test_every_input_is_solved_from_rest_with_the_effects_of_the_snapshots(source, monkeypatch):
    solved = []
    solve = EquilibriumSolver.solve

    def recorded(self, parameters):
        solved.append((float(parameters[0]), self.model.fibres.law))
        return solve(self, parameters)

    monkeypatch.setattr(EquilibriumSolver, "solve", recorded)
    seconds = TimedFullModel(*source).solve_seconds(np.array([[0.2], [0.3]]))
    assert solved[-2:] == [(0.2, HILL), (0.3, HILL)]
    assert seconds.shape == (2,) and (seconds > 0.0).all()


def test_way_from_a_guess_comes_closer_with_every_tangent_and_ends_in_the_equilibrium(source):
    path, provenance = source
    wanted = np.array([0.4])
    truth = EquilibriumSolver(EffectChoice(force_length=True).model(load_source(path))).solve(wanted).u
    way = TimedFullModel(path, provenance).way_from(0.7 * truth, wanted)
    np.testing.assert_array_equal(way[0][1], 0.7 * truth)
    distances = [np.abs(u - truth).max() for _, u in way]
    assert len(way) > 2
    assert distances == sorted(distances, reverse=True)
    assert distances[-1] < 1e-6 * np.abs(truth).max()
    seconds = [passed for passed, _ in way]
    assert seconds == sorted(seconds) and seconds[0] > 0.0


def test_way_to_what_has_no_equilibrium_ends_where_the_solver_gave_up(source):
    """A cell that is turned inside out, beyond mending, is where such a way begins and ends."""
    path, provenance = source
    guess = np.random.default_rng(0).normal(size=load_source(path).points.shape)
    way = TimedFullModel(path, provenance).way_from(guess, np.array([0.4]))
    assert len(way) == 1
    np.testing.assert_array_equal(way[0][1], guess)


def test_another_anatomy_is_refused(source):
    path, provenance = source
    with pytest.raises(InputError, match=r"block\.h5: is not the anatomy of the snapshots"):
        TimedFullModel(path, {**provenance, "anatomy": "0" * 64})
