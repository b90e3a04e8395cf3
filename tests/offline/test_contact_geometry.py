"""What a reduced model is told of an anatomy: teeth where there are any, else bones, and the seam of what is seen."""

from dataclasses import replace

import numpy as np
import pytest

from risorius.companion import JAW, SKULL, Companion
from risorius.errors import InputError
from risorius.surface import NO_COLOURS
from risorius_offline.anatomy.anatomy import Surface
from risorius_offline.anatomy.folder import JAW_BONE
from risorius_offline.anatomy.surface import as_triangles, boundary_faces
from risorius_offline.contact_geometry import SPACING, contact_geometry
from risorius_offline.head.bones import _sphere
from tests.offline.test_lip_seam import EDGE, blocks

RADIUS, GAP = 6e-3, 1e-3


def ball(centre):
    points, triangles = _sphere()
    return Surface(RADIUS * points + centre, triangles)


def two_blocks(**fields):
    anatomy = blocks(GAP)
    skin = as_triangles(boundary_faces(anatomy.cells), anatomy.points)
    return replace(anatomy, skin=skin, **fields)


def distance(obstacle, points, centre):
    return obstacle.distance(points) - (np.linalg.norm(points - centre, axis=1) - RADIUS)


def test_teeth_that_are_seen_take_the_place_of_bones():
    centre = np.array([0.005, 0.010, -0.008])
    teeth = ball(centre)
    companions = {
        "teeth_lower": Companion(teeth.points, teeth.triangles, NO_COLOURS, JAW),
        "tongue": Companion(teeth.points, teeth.triangles, NO_COLOURS),
    }
    geometry = contact_geometry(two_blocks(companions=companions, bones={"cranium": teeth}))
    assert list(geometry.obstacles) == ["teeth_lower"]
    obstacle = geometry.obstacles["teeth_lower"]
    assert obstacle.moves_with == JAW
    points = centre + np.random.default_rng(0).uniform(-7e-3, 7e-3, (200, 3))
    near = np.abs(np.linalg.norm(points - centre, axis=1) - RADIUS) < 3e-3
    facets = RADIUS * (1.0 - np.cos(np.pi / 32))  # what a sphere of such triangles recedes by
    assert np.abs(distance(obstacle, points[near], centre)).max() < facets + SPACING**2 / RADIUS


def test_bones_stand_for_teeth_where_none_are_seen():
    bones = {"cranium": ball(np.array([0.005, 0.010, -0.008])), JAW_BONE: ball(np.array([0.005, 0.0, -0.008]))}
    geometry = contact_geometry(two_blocks(bones=bones))
    assert {name: item.moves_with for name, item in geometry.obstacles.items()} == {"cranium": SKULL, JAW_BONE: JAW}


def test_bones_far_from_the_lips_are_left_out():
    geometry = contact_geometry(two_blocks(bones={"cranium": ball(np.array([0.3, 0.0, 0.0]))}))
    assert not geometry.obstacles


def test_seam_is_made_of_points_that_face_each_other():
    anatomy = two_blocks(bones={})
    geometry, points = contact_geometry(anatomy), anatomy.visible_surface.points
    heights = points[geometry.seam[:, 0], 1]
    assert set(np.round(heights, 9)) == {round(EDGE, 9), round(EDGE + GAP, 9)}
    across = points[anatomy.visible_surface.triangles[geometry.seam[:, 1]], 1]
    np.testing.assert_allclose(np.abs(across - heights[:, None]), GAP, atol=1e-9)


def test_surface_whose_sides_cannot_be_told_is_named():
    wrong = ball(np.zeros(3))
    wrong = Surface(wrong.points, np.concatenate([wrong.triangles[:1, ::-1], wrong.triangles[1:]]))
    with pytest.raises(InputError, match="'cranium'"):
        contact_geometry(two_blocks(bones={"cranium": wrong}))
