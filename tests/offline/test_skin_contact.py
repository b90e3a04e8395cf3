"""Skin between nodes stays out of teeth: forces against theory, rest free of forces, a tooth that no node can feel."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from risorius.companion import JAW, Companion
from risorius.errors import InputError
from risorius.jaw import JawMotion
from risorius.mechanics.material import Yeoh
from risorius.surface import NO_COLOURS, CarriedSurface
from risorius_offline.effects import DeadLoad
from risorius_offline.effects.skin_contact import GAP_TOLERANCE, PRESSURE, REACH, SkinContact
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel
from tests.offline.meshes import box
from tests.offline.models import block_anatomy
from tests.offline.test_bone_contact import box_surface, sphere_surface

TISSUE = Yeoh.neo_hookean(15e3, 0.3)
SIDE, COUNT, FINER = 0.02, 2, 8  # of the block, metres; its cells along an axis, and faces of the skin along a cell's
RADIUS = 3e-3
CENTRE = np.array([5e-3, 5e-3, -RADIUS - 1.5e-3])  # of a tooth, beneath the middle of a cell


def skin_beneath(points):
    """The lower side of the block as a surface of squares of a millimetre and a quarter, carried bilinearly."""
    n = COUNT * FINER
    x = np.linspace(0.0, SIDE, n + 1)
    places = np.array([(a, b, 0.0) for a in x for b in x])
    beneath = np.flatnonzero(np.isclose(points[:, 2], 0.0))
    hats = np.maximum(1.0 - np.abs(places[:, None, :2] - points[beneath][None, :, :2]) * COUNT / SIDE, 0.0).prod(axis=2)
    weights = sp.lil_matrix((len(places), len(points)))
    weights[:, beneath] = hats
    first = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    a, b, c, d = first, first + 1, first + n + 2, first + n + 1
    triangles = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return CarriedSurface(places, triangles, weights.tocsr(), NO_COLOURS)


def block(tooth):
    """A 20 mm cube of eight cells, fixed at its top, above a tooth of a jaw that moves in all its ways."""
    points, cells = box("hexahedron", (COUNT,) * 3)
    anatomy = block_anatomy(points, cells, TISSUE, fixed=np.isclose(points[:, 2], SIDE))
    teeth = {"teeth_lower": Companion(tooth.points, tooth.triangles, NO_COLOURS, JAW)}
    motion = JawMotion((0.01, 0.02, -0.05), 0.3, 0.002, 0.003, 0.004)
    return replace(anatomy, surface=skin_beneath(points), companions=teeth, jaw_motion=motion)


def ball():
    return sphere_surface(RADIUS, CENTRE, 16)


def test_skin_that_is_pressed_on_a_tooth_between_nodes_stays_out_of_it():
    anatomy = block(ball())
    load = np.where(np.isclose(anatomy.points[:, [2]], 0.0), [0.0, 0.0, -0.1], 0.0)
    rest, skin = np.zeros_like(anatomy.points), anatomy.visible_surface

    def depth(effects):
        parameters = np.zeros(len(anatomy.inputs.parameters))
        u = EquilibriumSolver(FullModel(anatomy, [DeadLoad(load), *effects])).settle(parameters, rest).u
        return float((RADIUS - np.linalg.norm(skin.points + skin.weights @ u - CENTRE, axis=1)).max())

    assert depth([]) > 1.5e-3
    assert -GAP_TOLERANCE < depth([SkinContact(anatomy)]) < 0.2e-3


def test_force_is_the_pressure_on_the_skin():
    """Over a flat tooth, at half of the tolerance: p0 / 4 on every square metre, whatever the weights of the nodes."""
    anatomy = block(box_surface((-0.03, -0.03, -0.02), (0.05, 0.05, -2e-3)))
    u, forces = np.zeros_like(anatomy.points), np.zeros_like(anatomy.points)
    u[:, 2] = -2e-3 + 0.5 * GAP_TOLERANCE
    energy = SkinContact(anatomy).add_forces(u, forces)
    np.testing.assert_allclose(-forces.sum(axis=0), [0.0, 0.0, PRESSURE / 4.0 * SIDE**2], atol=1e-9)
    assert energy == pytest.approx(PRESSURE * GAP_TOLERANCE / 24.0 * SIDE**2, rel=1e-9)
    assert not forces[~np.isclose(anatomy.points[:, 2], 0.0)].any()


def test_rest_is_free_of_contact_also_where_skin_is_in_a_tooth():
    anatomy = block(box_surface((-0.03, -0.03, -0.02), (0.05, 0.05, 1e-3)))
    assert SkinContact(anatomy).energy(np.zeros_like(anatomy.points)) == 0.0


def test_points_that_do_not_come_to_a_tooth_are_left_out():
    anatomy = block(ball())
    skin = anatomy.visible_surface
    away = np.linalg.norm(skin.points - CENTRE, axis=1) - RADIUS
    assert SkinContact(anatomy).weights.shape[0] == pytest.approx(np.count_nonzero(away < REACH), abs=8)


def test_forces_and_second_derivatives_are_those_of_the_energy():
    anatomy = block(ball())
    contact, rng = SkinContact(anatomy), np.random.default_rng(0)
    contact.set_parameters(np.array([0.05, 0.4, -0.3]))
    u = 3e-4 * rng.normal(size=anatomy.points.shape) - [0.0, 0.0, 2.2e-3]
    way, h = rng.normal(size=u.shape), 1e-8
    forces, ahead, behind = np.zeros_like(u), np.zeros_like(u), np.zeros_like(u)
    assert contact.add_forces(u, forces) == pytest.approx(contact.energy(u), rel=1e-14)
    contact.add_forces(u + h * way, ahead)
    contact.add_forces(u - h * way, behind)
    slope = (contact.energy(u + h * way) - contact.energy(u - h * way)) / (2.0 * h)
    assert float((forces * way).sum()) == pytest.approx(slope, rel=1e-6)
    found = contact.second_derivatives(u, project=False)
    assert len(found.nodes) >= 10
    along = way[found.nodes].reshape(len(found.nodes), -1)
    product = np.zeros_like(u)
    np.add.at(product, found.nodes, np.einsum("kij,kj->ki", found.matrices, along).reshape(*found.nodes.shape, 3))
    difference = (ahead - behind) / (2.0 * h)
    assert np.linalg.norm(product - difference) < 1e-6 * np.linalg.norm(difference)
    assert np.linalg.eigvalsh(found.matrices).min() < -1.0
    assert np.linalg.eigvalsh(contact.second_derivatives(u, project=True).matrices).min() > -1e-9


def test_teeth_that_cannot_be_used_are_named():
    anatomy = block(ball())
    tooth = anatomy.companions["teeth_lower"]
    triangles = tooth.triangles.copy()
    triangles[0] = triangles[0, ::-1]
    with pytest.raises(InputError, match=r"'teeth_lower': .* triangles run from point"):
        SkinContact(replace(anatomy, companions={"teeth_lower": replace(tooth, triangles=triangles)}))


def test_nothing_touches_without_skin_nearby():
    anatomy = block(box_surface((-0.03, -0.03, -0.05), (0.05, 0.05, -0.03)))
    contact, u = SkinContact(anatomy), np.zeros_like(anatomy.points)
    assert contact.energy(u) == contact.add_forces(u, np.zeros_like(u)) == 0.0
    assert not len(contact.second_derivatives(u, project=False).nodes)
