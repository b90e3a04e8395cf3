"""Upper lids in the full model: two plates in a block of tissue, mirrored, that turn about two centres."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from risorius.engine import Engine
from risorius.errors import InputError
from risorius.inputs import InputTable
from risorius.jaw import JawMotion
from risorius.lids import LidMotion
from risorius.mechanics.material import Yeoh
from risorius.model import load
from risorius.snapshot_file import SnapshotSet
from risorius.snapshot_store import Samples
from risorius.training import reduce_snapshots
from risorius_offline.anatomy.anatomy import LEFT_LID, RIGHT_LID, Anatomy
from risorius_offline.cluster import local_cluster
from risorius_offline.effects.bone_contact import BoneContact
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel
from risorius_offline.quantities import bone_reactions
from risorius_offline.sampling import design
from risorius_offline.sensitivities import sensitivities
from risorius_offline.snapshots import FullModelChoice, Run, solve_design
from tests.offline.meshes import box
from tests.offline.models import block_anatomy
from tests.offline.test_bone_contact import sphere_surface

ANGLE = 0.3
CENTRES = ((0.005, 0.010, 0.004), (-0.005, 0.010, 0.004))


@pytest.fixture(scope="module")
def anatomy() -> Anatomy:
    """A block of 20 mm, x from -10 to 10, fixed at z = 0, with a plate of a few nodes on top of either half."""
    points, cells = box("hexahedron", cells=(6, 3, 3))
    points = points - [0.01, 0.0, 0.0]
    x, y, z = points.T
    plate = np.isclose(z, 0.02) & (y > 0.005) & (y < 0.015)
    lids = np.zeros(len(points), dtype=np.int8)
    lids[plate & (x > 0.003)] = LEFT_LID
    lids[plate & (x < -0.003)] = RIGHT_LID
    block = block_anatomy(points, cells, Yeoh(2500.0, 1175.0, 250e3))
    return replace(block, lids=lids, lid_motion=LidMotion(CENTRES, ANGLE))


@pytest.fixture(scope="module")
def solver(anatomy: Anatomy) -> EquilibriumSolver:
    return EquilibriumSolver(FullModel(anatomy), tolerance=1e-11)


def test_plates_land_exactly_where_they_are_turned_to(anatomy, solver):
    weights = np.array([1.0, -0.4])
    u = solver.solve(weights).u
    for label, centre, weight in zip((LEFT_LID, RIGHT_LID), CENTRES, weights, strict=True):
        plate = anatomy.points[anatomy.lids == label]
        turned = Rotation.from_rotvec([weight * ANGLE, 0.0, 0.0]).apply(plate - centre) + centre
        np.testing.assert_allclose(u[anatomy.lids == label], turned - plate, atol=1e-15)
    np.testing.assert_array_equal(u[anatomy.skull], 0.0)


def test_one_lid_is_the_mirror_image_of_the_other(anatomy, solver):
    left, right = solver.solve(np.array([0.8, 0.0])).u, solver.solve(np.array([0.0, 0.8])).u
    mirrored = np.lexsort(np.round(anatomy.points * [-1.0, 1.0, 1.0], 9).T)
    straight = np.lexsort(np.round(anatomy.points, 9).T)
    scale = np.abs(left).max()
    np.testing.assert_allclose(left[straight], right[mirrored] * [-1.0, 1.0, 1.0], atol=1e-7 * scale)


def test_tissue_between_the_plates_follows(anatomy, solver):
    u = solver.solve(np.array([0.5, 0.5])).u
    free = ~anatomy.prescribed & np.isclose(anatomy.points[:, 2], 0.02)
    assert np.linalg.norm(u[free], axis=1).max() > 1e-4


def test_derivatives_by_lid_weights_are_those_of_the_solved_equilibrium(solver):
    state = np.array([0.6, -0.3])
    found = solver.solve(state)
    derivatives = sensitivities(solver.model, found)
    h = 1e-4
    for number in range(2):
        step = h * np.eye(2)[number]
        difference = (solver.solve(state + step, found).u - solver.solve(state - step, found).u) / (2 * h)
        np.testing.assert_allclose(derivatives[number], difference, atol=2e-7 * np.abs(difference).max())


def test_reactions_of_skull_and_lids_balance(solver):
    reactions = bone_reactions(solver.model, solver.solve(np.array([1.0, 0.2])))
    assert np.linalg.norm(reactions.lids) > 1e-3
    np.testing.assert_allclose(reactions.skull + reactions.lids, 0.0, atol=1e-8 * np.linalg.norm(reactions.lids))


def test_a_jaw_and_lids_move_each_their_own_nodes(anatomy):
    jaw = np.isclose(anatomy.points[:, 1], 0.0) & ~anatomy.skull
    motion = JawMotion((0.0, 0.0, 0.0), 0.0, 0.0, 0.0, sideways_slide=0.002)
    model = FullModel(replace(anatomy, jaw=jaw, jaw_motion=motion))
    u = model.prescribed_motion(np.array([0.0, 0.0, 0.5, 1.0, 0.0]))
    np.testing.assert_allclose(u[jaw], np.tile([0.001, 0.0, 0.0], (jaw.sum(), 1)), atol=1e-18)
    moved = np.flatnonzero(np.linalg.norm(u, axis=1))
    np.testing.assert_array_equal(moved, np.flatnonzero(jaw | (anatomy.lids == LEFT_LID)))


def test_bones_of_the_jaw_follow_its_weights_and_not_those_of_the_lids(anatomy):
    motion = JawMotion((0.0, 0.0, 0.0), 0.0, 0.0, forward_slide=0.002, sideways_slide=0.0)
    bone = sphere_surface(0.004, (0.0, 0.01, 0.025), 16)
    contact = BoneContact(replace(anatomy, jaw_motion=motion, bones={"jaw": bone}))
    rest = np.zeros_like(anatomy.points)
    gaps = []
    for parameters in ([0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0, -1.0], [0.0, -1.0, 0.0, 0.0, 0.0]):
        contact.set_parameters(np.array(parameters))
        gaps.append(contact.gaps(rest).min())
    assert gaps[1] == gaps[0]
    assert gaps[2] < gaps[0] - 0.001


def test_lids_that_move_need_their_nodes(anatomy):
    with pytest.raises(InputError, match="'block' has lid_motion but no lids; label the nodes"):
        replace(anatomy, lids=None)


def test_anatomy_with_lids_comes_back_from_its_file(anatomy, tmp_path):
    anatomy.save(tmp_path / "lids.h5")
    loaded = Anatomy.load(tmp_path / "lids.h5")
    np.testing.assert_array_equal(loaded.lids, anatomy.lids)
    assert loaded.poses == anatomy.poses
    assert loaded.inputs.parameters == ("upper_lid_L", "upper_lid_R")


def test_design_moves_lids_both_ways_together_and_alone():
    table = InputTable(("mentalis_L", "mentalis_R"), (*JawMotion.inputs, *LidMotion.inputs))
    lids = design(table, 400, 0, seed=1).parameters[:, -2:]
    for row in ([1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [-0.3, 0.0], [-0.3, -0.3]):
        assert (lids == row).all(axis=1).any()
    moved = lids[(lids != 0.0).any(axis=1)]
    assert 0.2 < len(moved) / len(lids) < 0.7
    assert moved.min() == -0.3
    assert (moved[:, 0] != moved[:, 1]).sum() > 20


def test_a_reduced_model_drives_the_plates_exactly(anatomy, tmp_path):
    weights = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [-0.25, 0.2], [0.3, 0.6], [0.5, 0.5]])
    plan = Samples(weights, ["pose"] * 6, np.arange(6) == 5, np.zeros(6, np.int64))
    with local_cluster(1) as client:
        solve_design(Run(FullModelChoice(anatomy), tmp_path / "s.h5"), plan, client, lambda status: None)
    reduce_snapshots(SnapshotSet.load(tmp_path / "s.h5"), 4).save(tmp_path / "model.h5")
    model = load(tmp_path / "model.h5")
    assert model.poses == anatomy.poses
    assert {"AU43_L", "AU5_R", "upper_lid_L", "upper_lid_R"} <= set(model.inputs.names)
    moved = Engine(model).evaluate({"upper_lid_L": 0.7, "upper_lid_R": -0.2}).vertices - model.rest_vertices
    exact = FullModel(anatomy).prescribed_motion(np.array([0.7, -0.2]))
    vertices = np.unique(anatomy.skin)
    plate = anatomy.lids[vertices] != 0
    fields, lifts = model.carried_basis.fields[: model.lifts], model.poses.lift_coordinates(np.array([0.7, -0.2]))
    rounding = np.abs(lifts) @ np.abs(fields).max(axis=(1, 2)) / np.iinfo(np.int16).max  # of fields of 16 bit
    assert rounding < 1e-6
    np.testing.assert_allclose(moved[plate], exact[vertices][plate], atol=rounding)
