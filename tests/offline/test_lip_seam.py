"""Contact at the seam of two blocks that face each other: pairs, energy, and how near they come under pressure."""

import numpy as np
import pytest

from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.discretisation import CellBlock
from risorius_offline.effects.contact_surface import ContactSurface
from risorius_offline.effects.dead_load import DeadLoad
from risorius_offline.effects.lip_seam import GAP_TOLERANCE, PRESSURE, REACH, LipSeam
from risorius_offline.full_model import FullModel
from risorius_offline.newton import GuardedNewton, SolverReport
from tests.offline.meshes import box

EDGE = 10e-3


def blocks(gap):
    """Two cubes with 10 mm edges, one above the other, each held on the side away from the gap."""
    lower, block = box("hexahedron", (3, 2, 3), (EDGE, EDGE, EDGE))
    upper = lower + np.array([0.0, EDGE + gap, 0.0])
    points = np.concatenate([lower, upper])
    connectivity = np.concatenate([block.connectivity, block.connectivity + len(lower)])
    return Anatomy(
        name="two blocks",
        points=points,
        cells=(CellBlock("hexahedron", connectivity, np.zeros(len(connectivity), dtype=np.int64)),),
        materials=(Yeoh.neo_hookean(15e3, 0.45),),
        skull=np.isclose(points[:, 1], 0.0) | np.isclose(points[:, 1], points[:, 1].max()),
        jaw=np.zeros(len(points), dtype=bool),
        skin=np.zeros((0, 3), dtype=np.int64),
        muscles=(),
        jaw_motion=None,
    )


def test_every_node_of_two_faces_that_meet_has_a_pair_and_no_other_node():
    anatomy = blocks(1e-3)
    facing = np.isclose(anatomy.points[:, 1], EDGE) | np.isclose(anatomy.points[:, 1], EDGE + 1e-3)
    np.testing.assert_array_equal(np.unique(LipSeam(anatomy).nodes[:, 0]), np.flatnonzero(facing))


def test_node_that_is_equally_near_several_triangles_shares_itself_among_them():
    """Opposite to a corner of the mesh every triangle around it is nearest, and the area counts once."""
    anatomy = blocks(1e-3)
    seam, surface = LipSeam(anatomy), ContactSurface.of(anatomy)
    u = np.where(anatomy.points[:, [1]] > EDGE + 0.5e-3, [0.0, -1e-3, 0.0], 0.0)
    forces = np.zeros_like(u)
    seam.add_forces(u, forces)
    area = surface.areas[np.isclose(surface.points[:, 1], EDGE)].sum()
    assert np.bincount(seam.nodes[:, 0]).max() > 1
    assert forces[: len(u) // 2, 1].sum() == pytest.approx(PRESSURE * area, rel=1e-9)


def test_faces_farther_apart_than_the_reach_are_no_seam():
    assert not len(LipSeam(blocks(1.1 * REACH)).nodes)


def test_gap_is_what_separates_the_faces():
    anatomy = blocks(1e-3)
    u = np.where(anatomy.points[:, [1]] > EDGE + 0.5e-3, [0.0, -0.7e-3, 0.0], 0.0)
    np.testing.assert_allclose(LipSeam(anatomy).gaps(u), 0.3e-3, rtol=1e-9)


def test_rest_is_free_of_contact_also_where_faces_are_nearer_than_the_tolerance():
    anatomy = blocks(0.1 * GAP_TOLERANCE)
    rest = np.zeros_like(anatomy.points)
    assert LipSeam(anatomy).energy(rest) == 0.0


def test_energy_of_closed_faces_is_the_pressure_integrated_over_the_gap():
    """Both sides together carry p(g) = p0 ((d - g) / d)^2; from g = d to 0 that is p0 d / 3 for every square metre."""
    anatomy = blocks(1e-3)
    u = np.where(anatomy.points[:, [1]] > EDGE + 0.5e-3, [0.0, -1e-3, 0.0], 0.0)
    facing = np.isclose(anatomy.points[:, 1], EDGE) | np.isclose(anatomy.points[:, 1], EDGE + 1e-3)
    surface = ContactSurface.of(anatomy)
    area = 0.5 * surface.areas[facing[surface.nodes]].sum()
    assert LipSeam(anatomy).energy(u) == pytest.approx(area * PRESSURE * GAP_TOLERANCE / 3.0, rel=1e-9)


def check_derivatives(effect, u, way):
    """Forces and second derivatives along a way are central differences of energy and forces."""
    forces, h = np.zeros_like(u), 1e-8
    assert effect.add_forces(u, forces) == effect.energy(u) > 0.0
    slope = (effect.energy(u + h * way) - effect.energy(u - h * way)) / (2.0 * h)
    assert float((forces * way).sum()) == pytest.approx(slope, rel=1e-6)
    ahead, behind = np.zeros_like(u), np.zeros_like(u)
    effect.add_forces(u + h * way, ahead)
    effect.add_forces(u - h * way, behind)
    found = effect.second_derivatives(u, project=False)
    along = way[found.nodes].reshape(len(found.nodes), -1)
    curvature = float(np.einsum("ki,kij,kj->", along, found.matrices, along))
    assert curvature == pytest.approx(float(((ahead - behind) * way).sum()) / (2.0 * h), rel=1e-5)


def test_forces_and_second_derivatives_are_those_of_the_energy():
    anatomy = blocks(0.4e-3)
    rng = np.random.default_rng(0)
    u, way = 2e-4 * rng.normal(size=anatomy.points.shape), rng.normal(size=anatomy.points.shape)
    check_derivatives(LipSeam(anatomy), u, way)


def turn(degrees):
    """Rotation about the z axis."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def test_lips_that_turn_together_and_slide_keep_their_gap():
    """Turned by 40 degrees, and the upper one moved along the slope by 4 mm: the distance between the faces stays."""
    anatomy = blocks(0.4e-3)
    moved = anatomy.points @ turn(40.0).T
    upper = anatomy.points[:, 1] > EDGE + 0.2e-3
    u = moved - anatomy.points + np.where(upper[:, None], 4e-3 * turn(40.0)[:, 0], 0.0)
    np.testing.assert_allclose(LipSeam(anatomy).gaps(u), 0.4e-3, rtol=1e-9)


def test_contact_forces_are_in_balance():
    """Neither a net force nor a net moment, wherever the lips have gone: the energy sees no rigid motion."""
    anatomy = blocks(0.4e-3)
    u = (
        anatomy.points @ turn(30.0).T
        - anatomy.points
        + 2e-4 * np.random.default_rng(1).normal(size=(len(anatomy.points), 3))
    )
    forces = np.zeros_like(u)
    LipSeam(anatomy).add_forces(u, forces)
    size = np.abs(forces).sum()
    assert size > 0.0
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-12 * size)
    np.testing.assert_allclose(np.cross(anatomy.points + u, forces).sum(axis=0), 0.0, atol=1e-12 * EDGE * size)


def test_projected_second_derivatives_are_positive_semi_definite():
    anatomy = blocks(0.4e-3)
    u = 2e-4 * np.random.default_rng(0).normal(size=anatomy.points.shape)
    lowest = {
        project: min(np.linalg.eigvalsh(m)[0] for m in LipSeam(anatomy).second_derivatives(u, project=project).matrices)
        for project in (True, False)
    }
    assert lowest[True] > -1e-9
    assert lowest[False] < -1.0


def test_blocks_pressed_together_do_not_pass_through_each_other():
    anatomy = blocks(1e-3)
    upper = np.isclose(anatomy.points[:, 1], EDGE + 1e-3)
    load = np.where(upper[:, None], [0.0, -0.02, 0.0], 0.0)
    seam = LipSeam(anatomy)
    u = {}
    for effects in ((DeadLoad(load),), (DeadLoad(load), seam)):
        model = FullModel(anatomy, effects)
        model.set_parameters(np.zeros(0))
        u[len(effects)] = GuardedNewton(1e-8, 50).minimise(model, np.zeros_like(anatomy.points), SolverReport())
    assert seam.gaps(u[1]).min() < 0.0
    assert seam.gaps(u[2]).min() > 0.0
