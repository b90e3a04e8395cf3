"""The full model in the report of a reduced one: the same anatomy, the same effects, the inputs that were asked for."""

from __future__ import annotations

import numpy as np
import pytest

from risorius.errors import InputError
from risorius.mechanics.fibres import HILL
from risorius.mechanics.material import Yeoh
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.timed_solves import timed_solves
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
    seconds = timed_solves(*source, np.array([[0.2], [0.3]]))
    assert solved[-2:] == [(0.2, HILL), (0.3, HILL)]
    assert seconds.shape == (2,) and (seconds > 0.0).all()


def test_another_anatomy_is_refused(source):
    path, provenance = source
    with pytest.raises(InputError, match=r"block\.h5: is not the anatomy of the snapshots"):
        timed_solves(path, {**provenance, "anatomy": "0" * 64}, np.array([[0.2]]))
