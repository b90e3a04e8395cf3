"""Winding numbers of skin around a mouth and its cone, against those of the whole surface."""

import numpy as np
import pytest

from risorius.effects.skin_around import SkinAround, place_skin
from risorius.winding_number import winding_number, winding_number_of

RADIUS = 80e-3


def ball():
    """Points (n, 3) of a ball, open at its lower end, and its triangles, seen from outside."""
    polar, round_ = np.linspace(1e-6, 0.85 * np.pi, 40), 2.0 * np.pi * np.arange(60) / 60
    p, r = np.meshgrid(polar, round_, indexing="ij")
    points = RADIUS * np.stack([np.sin(p) * np.cos(r), np.sin(p) * np.sin(r), np.cos(p)], axis=2).reshape(-1, 3)
    here = 60 * np.arange(39)[:, None] + np.arange(60)
    right = 60 * np.arange(39)[:, None] + (np.arange(60) + 1) % 60
    triangles = np.concatenate([np.stack([here, here + 60, right], 2), np.stack([right, here + 60, right + 60], 2)])
    return points.astype(np.float32), triangles.reshape(-1, 3).astype(np.int32)


@pytest.fixture
def cap():
    """A ball, and what is left of it around its upper end when a cone stands for the rest."""
    rest, triangles = ball()
    vertices = np.flatnonzero(rest[:, 2] > 0.5 * RADIUS).astype(np.int32)
    return rest, triangles, SkinAround.of(vertices, rest, triangles)


def wound(around, x, place):
    corners = np.zeros((9, around.size), np.float32)
    place_skin(x, around.triangles, around.edges, around.apex, corners)
    return winding_number_of(*place.astype(np.float32), corners)


def test_growth_is_that_of_the_whole_surface_however_it_is_dented(cap):
    rest, triangles, around = cap
    assert len(around.triangles) < 0.5 * len(triangles)
    rng, grown = np.random.default_rng(0), []
    for _ in range(40):
        dent, side = rng.uniform(-20e-3, 20e-3, 3), rng.uniform(-1.0, 1.0, 3)
        x = (rest + np.exp(-((np.linalg.norm(rest - RADIUS * side, axis=1) / 50e-3)[:, None] ** 2)) * dent).astype(
            np.float32
        )
        place = np.array([*rng.uniform(-20e-3, 20e-3, 2), rng.uniform(0.6, 1.1) * RADIUS])
        whole = [winding_number(place, one.astype(np.float64), triangles) for one in (x, rest)]
        growth = wound(around, x, place) - wound(around, rest, place)
        assert growth == pytest.approx(whole[0] - whole[1], abs=2e-3)
        grown.append(abs(growth) > 0.5)
    assert any(grown)
    assert not all(grown)
