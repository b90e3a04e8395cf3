"""Masks of lanes against the same questions, asked one by one."""

import numba
import numpy as np
import pytest

from risorius.vector_lanes import LANES
from risorius.vector_masks import first_lane, lanes_behind, lanes_within


@numba.njit
def _within(spheres, place, reach):
    return lanes_within(spheres[0], spheres[1], spheres[2], spheres[3], LANES, place[0], place[1], place[2], reach)


@numba.njit
def _behind(planes, place):
    return lanes_behind(planes[0], planes[1], planes[2], planes[3], LANES, place[0], place[1], place[2])


@numba.njit
def _first(mask):
    return first_lane(mask)


def flags(mask):
    return [bool(mask >> lane & 1) for lane in range(LANES)]


@pytest.mark.parametrize("seed", range(20))
def test_masks_tell_what_every_lane_would(seed):
    rng = np.random.default_rng(seed)
    spheres, place = rng.normal(size=(4, 2 * LANES)).astype(np.float32), rng.normal(size=3).astype(np.float32)
    spheres[3] = np.abs(spheres[3])
    mine = spheres[:, LANES:]
    mask = _within(spheres, place, np.float32(0.5))
    distances = np.linalg.norm(mine[:3] - place[:, None], axis=0)
    assert flags(mask) == list(distances < mine[3] + 0.5)
    if mask:
        assert flags(mask).index(True) == _first(mask)
    planes = rng.normal(size=(4, 2 * LANES)).astype(np.float32)
    assert flags(_behind(planes, place)) == list(place @ planes[:3, LANES:] < planes[3, LANES:])
