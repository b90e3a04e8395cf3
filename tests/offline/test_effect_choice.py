"""What is chosen is in the model, and what is not chosen is absent."""

from dataclasses import replace

import numpy as np
import pytest

from risorius.errors import InputError
from risorius.mechanics.material import Yeoh
from risorius.snapshot_file import SnapshotSet
from risorius.snapshot_store import Samples
from risorius_offline.anatomy.anatomy import Surface
from risorius_offline.anatomy.surface import as_triangles, boundary_faces
from risorius_offline.cluster import local_cluster
from risorius_offline.contact_choice import ContactChoice
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.effects import DeadLoad
from risorius_offline.effects.bone_contact import BoneContact
from risorius_offline.effects.lip_contact import LipContact
from risorius_offline.effects.skin_prestress import SkinPrestress
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.snapshots import FullModelChoice, Run, solve_design
from tests.offline.meshes import box
from tests.offline.models import muscle_block


@pytest.fixture
def anatomy():
    """A cube of tissue with a muscle, above a bone."""
    points, cells = box("hexahedron")
    bone = Surface(points - np.array([0.0, 0.0, 0.021]), as_triangles(boundary_faces([cells]), points))
    return replace(muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3)), bones={"maxilla": bone})


@pytest.mark.parametrize(
    ("choice", "kinds"),
    [
        (EffectChoice(), []),
        (EffectChoice(contact=ContactChoice.FULL), [BoneContact, LipContact]),
        (EffectChoice(gravity=(0.0, 0.0, -9.81), prestress=10e3), [DeadLoad, SkinPrestress]),
        (EffectChoice(force_length=True), []),
    ],
)
def test_a_model_has_the_effects_that_are_chosen(anatomy, choice, kinds):
    assert [type(effect) for effect in choice.model(anatomy).effects] == kinds


def test_muscles_after_hill_pull_by_their_curve(anatomy):
    """At the same displacement the fibre stress is f = exp(-(stretch - 1)^2 / 0.45) instead of the stretch."""
    u = -0.2 * anatomy.points * np.array([1.0, 0.0, 0.0])
    stretched = [choice.model(anatomy).muscle_forces(u) for choice in (EffectChoice(), EffectChoice(force_length=True))]
    by_stretch, by_hill = (np.abs(columns[::3, 0]).sum() for columns in stretched)
    # The fibre line climbs 2 mm in 20: its stretch is a little above 0.8, within a tenth of a per cent.
    assert by_hill / by_stretch == pytest.approx(np.exp(-(0.2**2) / 0.45) / 0.8, rel=5e-3)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"prestress": -1.0}, "skin pre-stress -1 Pa"),
        ({"gravity": (0.0, np.nan, 0.0)}, "gravity .* three finite numbers"),
    ],
)
def test_impossible_choices_are_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        EffectChoice(**wrong)


@pytest.fixture(scope="module")
def worker():
    with local_cluster(1) as client:
        yield client


def samples(*weights):
    number = np.arange(len(weights))
    return Samples(np.array(weights)[:, None], ["level"] * len(weights), number == len(weights) - 1, number // 4)


def test_snapshots_have_the_effects_and_say_which(anatomy, worker, tmp_path):
    choice = EffectChoice(force_length=True)
    solve_design(Run(FullModelChoice(anatomy, choice), tmp_path / "s.h5"), samples(1.0, 0.5), worker, lambda _: None)
    found = SnapshotSet.load(tmp_path / "s.h5")
    exact = EquilibriumSolver(choice.model(anatomy), tolerance=1e-10).solve(np.array([1.0])).u
    np.testing.assert_allclose(found.displacements[0], exact, atol=1e-5 * np.abs(exact).max())
    assert found.provenance["effect_force_length"] is True
    assert found.provenance["effect_contact"] == "none"


def test_snapshots_with_other_effects_are_not_gone_on_with(anatomy, worker, tmp_path):
    solve_design(Run(FullModelChoice(anatomy), tmp_path / "s.h5"), samples(1.0), worker, lambda _: None)
    other = Run(FullModelChoice(anatomy, EffectChoice(force_length=True)), tmp_path / "s.h5")
    with pytest.raises(InputError, match="holds snapshots with effect_force_length = False, asked for is True"):
        solve_design(other, samples(1.0), worker, lambda _: None)
