"""A visible surface finer than the mesh, from the anatomy to the frames of its model."""

from dataclasses import replace

import numpy as np
import pytest

from risorius import Engine, Scene, carried_basis
from risorius.companion import Companion
from risorius.errors import InputError
from risorius.mechanics.material import Yeoh
from risorius.snapshot_file import SnapshotSet
from risorius.snapshot_store import Samples
from risorius.surface import CarriedSurface
from risorius.training import reduce_snapshots
from risorius_offline.anatomy import Anatomy
from risorius_offline.cluster import local_cluster
from risorius_offline.snapshots import FullModelChoice, Run, solve_design
from risorius_offline.subdivision import refine
from tests.offline.models import muscle_block


@pytest.fixture(scope="module")
def plain():
    return muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3))


@pytest.fixture(scope="module")
def finer(plain):
    weights, triangles = refine(plain.skin, len(plain.points), 2)
    colours = np.full((weights.shape[0], 3), (200, 150, 130), dtype=np.uint8)
    surface = CarriedSurface(weights @ plain.points, triangles, weights, colours)
    stone = Companion(np.eye(3), np.array([[0, 1, 2]]), np.zeros((3, 3), np.uint8))
    return replace(plain, surface=surface, companions={"stone": stone})


@pytest.fixture(scope="module")
def snapshots(plain, finer, tmp_path_factory):
    """Snapshots of the plain block and of the one with a finer surface."""
    folder = tmp_path_factory.mktemp("snapshots")
    levels = np.array([1.0, 0.4, 0.7])[:, None]
    plan = Samples(levels, ["level"] * 3, levels[:, 0] == 0.7, np.zeros(3, np.int64))
    found = []
    with local_cluster(1) as client:
        for number, anatomy in enumerate((plain, finer)):
            path = folder / f"{number}.h5"
            solve_design(Run(FullModelChoice(anatomy), path), plan, client, lambda status: None)
            found.append(SnapshotSet.load(path))
    return found


def test_an_anatomy_without_a_surface_of_its_own_shows_the_nodes_of_its_skin(plain, tmp_path):
    visible = plain.visible_surface
    np.testing.assert_array_equal(visible.points[visible.triangles], plain.points[plain.skin])
    plain.save(tmp_path / "plain.h5")
    assert Anatomy.load(tmp_path / "plain.h5").surface is None


def test_an_anatomy_file_keeps_surface_and_companions(finer, tmp_path):
    finer.save(tmp_path / "finer.h5")
    loaded = Anatomy.load(tmp_path / "finer.h5")
    assert loaded.checksum() == finer.checksum()
    assert (loaded.surface.weights != finer.surface.weights).nnz == 0
    assert set(loaded.companions) == {"stone"}


def test_a_surface_of_another_mesh_is_refused(plain, finer):
    foreign = CarriedSurface.of_nodes(plain.points[:4], np.array([[0, 1, 2]]))
    with pytest.raises(InputError, match="carried by 4 nodes, the mesh has"):
        replace(finer, surface=foreign)


def test_a_frame_shows_where_the_nodes_of_the_equilibrium_carry_the_surface(finer, snapshots, monkeypatch):
    monkeypatch.setattr(carried_basis, "ROUNDED_OFF", 0.0)
    model = reduce_snapshots(snapshots[1], rank=4)
    vertices = Engine(model, Scene(nonlinear=False)).evaluate(muscles={"pull": 1.0}).vertices
    expected = finer.surface.points + finer.surface.weights @ snapshots[1].displacements[0].astype(np.float64)
    moved = np.abs(expected - finer.surface.points).max()
    assert len(vertices) > 8 * len(np.unique(finer.skin))
    assert np.abs(vertices - expected).max() < 1e-4 * moved
    assert set(model.companions) == {"stone"}
    np.testing.assert_array_equal(model.colours, finer.surface.colours)


def test_what_is_seen_changes_nothing_about_the_physics(snapshots):
    np.testing.assert_array_equal(*(found.displacements for found in snapshots))
