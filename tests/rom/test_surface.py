"""The visible surface and the rigid things beside it: what carries them, and that files keep them."""

import json
from dataclasses import replace

import h5py
import numpy as np
import pytest
import scipy.sparse as sp
import typer
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

import risorius
from risorius.carried_basis import CarriedBasis
from risorius.commands import register
from risorius.companion import JAW, SKULL, Companion
from risorius.errors import InputError
from risorius.jaw import JawMotion
from risorius.lids import LidMotion
from risorius.poses import Poses
from risorius.surface import CarriedSurface

MOTION = JawMotion((0.0, -0.03, -0.09), 0.5, opening_slide=0.008, forward_slide=0.005, sideways_slide=0.01)
LIDS = LidMotion(((0.03, 0.0, 0.0), (-0.03, 0.0, 0.0)), 0.8)


def thing(moves_with, count=9):
    rng = np.random.default_rng(3)
    colours = rng.integers(0, 256, (count, 3)).astype(np.uint8)
    return Companion(0.05 * rng.normal(size=(count, 3)), rng.integers(0, count, (7, 3)), colours, moves_with)


def surface():
    rng = np.random.default_rng(4)
    weights = sp.random(30, 12, 0.3, format="csr", rng=rng)
    colours = rng.integers(0, 256, (30, 3)).astype(np.uint8)
    return CarriedSurface(rng.normal(size=(30, 3)), rng.integers(0, 30, (40, 3)), weights, colours)


def test_the_skins_own_nodes_are_carried_as_they_are():
    rng = np.random.default_rng(0)
    points, skin = rng.normal(size=(20, 3)), np.array([[17, 3, 5], [5, 3, 11], [2, 17, 5]])
    visible = CarriedSurface.of_nodes(points, skin)
    np.testing.assert_array_equal(visible.points, points[[2, 3, 5, 11, 17]])
    np.testing.assert_array_equal(visible.points[visible.triangles], points[skin])
    fields = rng.normal(size=(4, 20, 3)).astype(np.float32)
    np.testing.assert_array_equal(visible.carry(fields), fields[:, [2, 3, 5, 11, 17]])
    assert not len(visible.colours)


def test_displacements_are_carried_by_the_weights():
    visible, fields = surface(), np.random.default_rng(1).normal(size=(2, 12, 3))
    expected = np.einsum("vn,kni->kvi", visible.weights.toarray(), fields)
    np.testing.assert_allclose(visible.carry(fields), expected, atol=1e-15)


def test_a_surface_comes_back_from_a_file_as_it_was(tmp_path):
    visible = surface()
    with h5py.File(tmp_path / "surface.h5", "w") as file:
        visible.write(file)
        found = CarriedSurface.read(file)
    for name in ("points", "triangles", "colours"):
        np.testing.assert_array_equal(getattr(found, name), getattr(visible, name))
        assert getattr(found, name).dtype == getattr(visible, name).dtype
    np.testing.assert_array_equal(found.weights.toarray(), visible.weights.toarray())


@pytest.mark.parametrize("poses", [Poses(MOTION), Poses(MOTION, LIDS)])
@pytest.mark.parametrize("weights", [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.6, -1.0, 0.4)])
def test_a_companion_of_the_jaw_moves_as_the_jaw_does(poses, weights):
    teeth = thing(JAW)
    opening, forward, sideways = weights
    centre = np.array(MOTION.condyle_centre)
    turned = Rotation.from_rotvec([0.5 * opening, 0.0, 0.0]).apply(teeth.points - centre) + centre
    slide = np.array([0.01 * sideways, 0.0, 0.008 * opening + 0.005 * forward])
    lids = np.full(len(poses.inputs) - 3, 0.7)
    coordinates = np.concatenate([poses.lift_coordinates([*weights, *lids]), [0.3, -2.0]])
    np.testing.assert_allclose(teeth.posed(poses, coordinates), turned + slide, atol=1e-15)


def test_a_companion_of_the_skull_stays():
    eye = thing(SKULL)
    np.testing.assert_array_equal(eye.posed(Poses(MOTION), np.full(6, 0.3)), eye.points)


def test_a_face_without_a_jaw_leaves_its_companions_where_they_are():
    teeth = thing(JAW)
    np.testing.assert_array_equal(teeth.posed(Poses(lids=LIDS), np.full(6, 0.3)), teeth.points)


def test_a_companion_of_anything_else_is_refused():
    with pytest.raises(InputError, match="'tongue'; give 'skull' or 'jaw'"):
        thing("tongue")


@pytest.fixture
def seen(synthetic_model):
    """The synthetic model with colours and companions."""
    colours = np.random.default_rng(5).integers(0, 256, synthetic_model.rest_vertices.shape).astype(np.uint8)
    return replace(synthetic_model, colours=colours, companions={"eye": thing(SKULL), "teeth": thing(JAW)})


def test_a_model_keeps_colours_and_companions(seen, tmp_path):
    seen.save(tmp_path / "model.h5")
    loaded = risorius.load(tmp_path / "model.h5")
    np.testing.assert_array_equal(loaded.colours, seen.colours)
    assert set(loaded.companions) == {"eye", "teeth"}
    for name, companion in seen.companions.items():
        found = loaded.companions[name]
        assert found.moves_with == companion.moves_with
        for key in ("points", "triangles", "colours"):
            np.testing.assert_array_equal(getattr(found, key), getattr(companion, key))


def test_teeth_stay_in_the_jaw_of_an_evaluated_face(seen):
    """A vertex that moves with the jaw alone, seen as a companion too, does not part from itself."""
    teeth = seen.companions["teeth"]
    basis = np.concatenate([seen.poses.jaw.unit_motions(teeth.points), np.zeros((6, 9, 3))]).astype(np.float32)
    carried = replace(
        seen, rest_vertices=teeth.points.astype(np.float32), carried_basis=CarriedBasis.of_vertices(basis)
    )
    frame = risorius.Engine(carried).evaluate({"jaw_open": 0.8, "jaw_sideways": -0.5, "AU12": 1.0})
    rounding = np.abs(frame.coordinates) @ np.abs(basis).max(axis=(1, 2)) / np.iinfo(np.int16).max  # of 16-bit fields
    assert rounding < 4e-6
    np.testing.assert_allclose(teeth.posed(seen.poses, frame.coordinates), frame.vertices, atol=rounding)


def test_info_tells_colours_and_companions(seen, tmp_path):
    app = typer.Typer()
    register(app)
    seen.save(tmp_path / "model.h5")
    told = json.loads(CliRunner().invoke(app, ["info", str(tmp_path / "model.h5"), "--json"]).stdout)
    assert told["coloured"] is True
    assert told["companions"]["teeth"] == {"vertices": 9, "triangles": 7, "moves_with": "jaw"}
    plain = CliRunner().invoke(app, ["info", str(tmp_path / "model.h5")]).stdout
    assert "320 vertices with colours, 570 triangles" in plain
    assert "seen with it: eye (9 vertices, skull), teeth (9 vertices, jaw)" in plain
