"""Blocks of triangles: what is in them, and around them, worked out plainly."""

import numpy as np
import pytest

from risorius.effects.lane_blocks import NOWHERE, blocks_of, enclose, turn_planes
from risorius.vector_lanes import LANES
from risorius.winding_number import place_corners


@pytest.fixture
def soup():
    """Triangles of some millimetres, here and there, on either side, and their blocks."""
    rng = np.random.default_rng(0)
    x = (rng.uniform(-30e-3, 30e-3, (100, 1, 3)) + rng.normal(scale=1e-3, size=(100, 3, 3))).astype(np.float32)
    triangles, sides = np.arange(300, dtype=np.int32).reshape(100, 3), np.repeat([1, 0, -1], [60, 30, 10])
    return x.reshape(-1, 3), triangles, sides, *blocks_of(x.mean(axis=1), sides)


def test_every_triangle_of_a_side_is_in_one_block_of_it(soup):
    _, _, sides, blocks, split = soup
    assert len(blocks) % LANES == split % LANES == 0
    for side, mine in enumerate((blocks[:split], blocks[split:])):
        np.testing.assert_array_equal(np.unique(mine[mine >= 0]), np.flatnonzero(sides == side))
        assert np.count_nonzero(mine[:, 0] >= 0) == -(-np.count_nonzero(sides == side) // LANES)


def test_spheres_enclose_all_corners_of_a_block(soup):
    x, triangles, _, blocks, _ = soup
    corners, spheres = np.zeros((9, blocks.size), np.float32), np.full((4, len(blocks)), NOWHERE, np.float32)
    place_corners(x, triangles[np.maximum(blocks, 0).ravel()], corners)
    enclose(corners, blocks, spheres)
    for block, (*centre, radius) in zip(blocks, spheres.T, strict=True):
        if block[0] < 0:
            assert centre == [NOWHERE] * 3
            continue
        places = x[triangles[block]].reshape(-1, 3)
        away = np.linalg.norm(places - np.array(centre), axis=1).max()
        assert away <= radius <= 1.001 * away + 1e-6
        np.testing.assert_allclose(centre, places.mean(axis=0), atol=1e-7)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_planes_hold_the_corners_of_their_triangles_and_face_outwards(soup, sign):
    x, triangles, *_ = soup
    corners, sizes = np.zeros((9, len(triangles)), np.float32), np.zeros(len(triangles), np.float32)
    planes = np.zeros((4, len(triangles)), np.float32)
    place_corners(x, triangles, corners)
    turn_planes(corners, sign, sizes, planes)
    a, b, c = x[triangles].astype(np.float64).transpose(1, 0, 2)
    outward = sign * np.cross(b - a, c - a)
    np.testing.assert_allclose(planes[:3].T, outward, rtol=1e-4, atol=1e-11)
    heights = np.einsum("kni,ni->kn", np.stack([a, b, c]), outward) - planes[3]
    assert np.abs(heights).max() < 1e-6 * np.linalg.norm(outward, axis=1).max()
    np.testing.assert_allclose(sizes, np.maximum(*(np.linalg.norm(one - a, axis=1) for one in (b, c))), rtol=1e-3)
