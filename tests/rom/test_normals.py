import numpy as np
import pytest
import pyvista as pv

from risorius.normals import vertex_normals


def on_sphere(subdivisions):
    sphere = pv.Icosphere(radius=0.08, nsub=subdivisions)
    return np.array(sphere.points, np.float32), sphere.faces.reshape(-1, 4)[:, 1:].astype(np.int32)


def test_normals_of_an_icosahedron_point_away_from_its_centre():
    points, triangles = on_sphere(0)
    np.testing.assert_allclose(vertex_normals(points, triangles), points / 0.08, atol=1e-6)


@pytest.mark.parametrize("subdivisions", [2, 3, 4, 5])
def test_normals_of_a_sphere_are_off_by_a_twentieth_of_the_angle_of_an_edge(subdivisions):
    """First order in the edges is what the theory has for uneven triangles (Meek and Walton 2000)."""
    points, triangles = on_sphere(subdivisions)
    longest = np.linalg.norm(points[triangles] - points[np.roll(triangles, 1, axis=1)], axis=2).max() / 0.08
    assert np.abs(vertex_normals(points, triangles) - points / 0.08).max() < 0.05 * longest


def test_normals_fill_the_array_that_is_given():
    points, triangles = on_sphere(1)
    out = np.full_like(points, np.nan)
    assert vertex_normals(points, triangles, out=out) is out
    np.testing.assert_array_equal(out, vertex_normals(points, triangles))


def test_areas_are_the_weights():
    """Three faces of a corner, one of them three times as long as the others: (bc, ca, ab) of its edges."""
    a, b, c = 3.0, 1.0, 1.0
    points = np.array([[0, 0, 0], [a, 0, 0], [0, b, 0], [0, 0, c]], dtype=np.float32)
    normals = vertex_normals(points, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1]], dtype=np.int32))
    np.testing.assert_allclose(normals[0], np.array([b * c, c * a, a * b]) / np.sqrt(19.0), rtol=1e-6)


def test_a_vertex_without_area_has_none():
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [5, 5, 5]], dtype=np.float32)
    assert not vertex_normals(points, np.array([[0, 1, 2]], dtype=np.int32)).any()
