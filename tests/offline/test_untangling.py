"""Guesses that turn cells inside out become states that a solve may start from."""

from dataclasses import replace

import numpy as np
import pytest

from risorius_offline.discretisation import Discretisation
from risorius_offline.effects.bone_contact import BoneContact
from risorius_offline.full_model import FullModel
from risorius_offline.jacobian_bounds import jacobian_bounds
from risorius_offline.untangling import Untangling
from tests.offline.meshes import box
from tests.offline.test_bone_contact import box_surface, tissue_block

TWIST = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def tangled(cell_type):
    """A block, turned by a right angle, one inner node of which is beyond its neighbours; and that node."""
    points, cells = box(cell_type, (8, 8, 8), (0.08,) * 3, 0.1)
    u = points @ TWIST.T - points
    node = int(np.linalg.norm(points - 0.04, axis=1).argmin())
    u[node] += [0.017, 0.004, -0.003]
    return Discretisation(points, [cells]), u, node


@pytest.mark.parametrize("cell_type", ["tetra", "hexahedron", "wedge"])
def test_cells_are_turned_back_and_distant_ones_are_not_touched(cell_type):
    discretisation, u, node = tangled(cell_type)
    assert not jacobian_bounds(discretisation, u).positive
    found = Untangling(discretisation, np.zeros(len(u), bool)).untangled(u)
    assert jacobian_bounds(discretisation, found).positive
    points = discretisation.points
    distant = np.linalg.norm(points - points[node], axis=1) > 0.052
    assert distant.sum() > len(points) // 5
    np.testing.assert_array_equal(found[distant], u[distant])


def test_prescribed_and_kept_nodes_stay():
    discretisation, u, node = tangled("hexahedron")
    near = np.linalg.norm(discretisation.points - discretisation.points[node], axis=1) < 0.011
    for prescribed, kept in ((near, None), (np.zeros(len(u), bool), near)):
        found = Untangling(discretisation, prescribed).untangled(u, kept)
        np.testing.assert_array_equal(found[near], u[near])
        assert not np.array_equal(found, u)


def test_admissible_displacement_is_left_as_it_is():
    discretisation, _, _ = tangled("wedge")
    u = np.random.default_rng(0).normal(scale=5e-4, size=discretisation.points.shape)
    np.testing.assert_array_equal(Untangling(discretisation, np.zeros(len(u), bool)).untangled(u), u)


def test_tissue_that_went_into_a_bone_comes_out_without_a_fold():
    floor = box_surface((-0.03, -0.03, -0.02), (0.05, 0.05, -1e-3))
    anatomy = replace(tissue_block(), bones={"maxilla": floor})
    contact = BoneContact(anatomy)
    model = FullModel(anatomy, [contact])
    low = np.isclose(anatomy.points[:, 2], 0.0)
    u = np.zeros_like(anatomy.points)
    u[low, 2] = -5e-3
    u[low & np.isclose(anatomy.points[:, 0], 0.01), 0] = 0.012
    assert not model.admits(u)
    found = model.admissible(u)
    assert model.admits(found)
    assert contact.gaps(found).min() >= -1.5e-3


def test_displacement_that_nothing_can_mend_is_refused():
    anatomy = tissue_block()
    model = FullModel(anatomy)
    assert model.admissible(np.full_like(anatomy.points, np.nan)) is None
