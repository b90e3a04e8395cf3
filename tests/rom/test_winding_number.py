"""Winding numbers against what they are of closed, doubled and half surfaces."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from risorius.winding_number import winding_number


def ball():
    """Points of the unit sphere, and outward triangles; the equator is among them."""
    rng = np.random.default_rng(0)
    upper = rng.normal(size=(200, 3)) * [1.0, 1.0, 0.5]
    angle = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    points = np.concatenate([upper, np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])])
    points /= np.linalg.norm(points, axis=1)[:, None]
    triangles = ConvexHull(points).simplices.astype(np.int32)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    inward = np.einsum("ti,ti->t", np.cross(b - a, c - a), a) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    return points, triangles


@pytest.mark.parametrize(("point", "wanted"), [((0.3, -0.2, 0.4), 1.0), ((0.0, 0.0, 0.0), 1.0), ((0.0, 1.5, 0.3), 0.0)])
def test_closed_surface(point, wanted):
    points, triangles = ball()
    assert winding_number(np.array(point), points, triangles) == pytest.approx(wanted, abs=1e-12)
    assert winding_number(np.array(point), points, triangles[:, ::-1]) == pytest.approx(-wanted, abs=1e-12)


def test_surface_that_is_there_several_times_counts_as_often():
    points, triangles = ball()
    assert winding_number(np.array([0.3, -0.2, 0.4]), points, np.tile(triangles, (5, 1))) == pytest.approx(
        5.0, abs=1e-12
    )
    several = np.concatenate([triangles[:, ::-1]] * 3)
    assert winding_number(np.array([0.3, -0.2, 0.4]), points, several) == pytest.approx(-3.0, abs=1e-12)


def test_open_surface_counts_by_the_directions_that_it_covers():
    points, triangles = ball()
    part = triangles[points[triangles].mean(axis=1)[:, 2] > 0.3]
    direct = 0.0  # of the solid angle, by rays
    rng = np.random.default_rng(1)
    rays = rng.normal(size=(4000, 3))
    a, b, c = (points[part[:, k]] for k in range(3))
    for ray in rays:
        signs = [np.einsum("ti,i->t", np.cross(u, v), ray) > 0.0 for u, v in ((a, b), (b, c), (c, a))]
        direct += np.logical_and.reduce(signs).any()
    assert winding_number(np.zeros(3), points, part) == pytest.approx(direct / len(rays), abs=0.02)
