"""Square-root-of-three subdivision: what it keeps, what it smooths, and that it stays a surface."""

from itertools import pairwise

import numpy as np
import pytest

from risorius.errors import InputError
from risorius_offline.subdivision import refine


def grid(columns, rows):
    """Flat regular patch of equilateral triangles: points (n, 3), triangles (t, 3) seen from above."""
    i, j = np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
    points = np.stack([i + 0.5 * j, np.sqrt(0.75) * j, 0.0 * i], axis=-1).reshape(-1, 3)
    corner = (i * rows + j)[:-1, :-1].ravel()
    right, up = corner + rows, corner + 1
    return points, np.concatenate([np.column_stack([corner, right, up]), np.column_stack([right, right + 1, up])])


def with_two_holes():
    """The patch without two triangles that do not touch, and thus with three boundary loops."""
    points, triangles = grid(9, 8)
    return points, np.delete(triangles, [10, 80], axis=0)


def octahedron(halvings):
    """A closed surface of 8 * 4^halvings triangles, its points on the unit sphere."""
    points = np.concatenate([np.eye(3), -np.eye(3)])
    triangles = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    for _ in range(halvings):
        edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        pairs, number = np.unique(edges, axis=0, return_inverse=True)
        a, b, c = triangles.T
        ab, bc, ca = (len(points) + number.reshape(-1, 3)).T
        points = np.concatenate([points, points[pairs].mean(axis=1)])
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        corners = ([a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca])
        triangles = np.concatenate([np.column_stack(corner) for corner in corners])
    return points, triangles


def directed_edges(triangles):
    return np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])


def boundary(triangles):
    """(k, 2) directed edges without an opposite one."""
    edges = {(int(a), int(b)) for a, b in directed_edges(triangles)}
    return np.array(sorted(edge for edge in edges if edge[::-1] not in edges)).reshape(-1, 2)


def loops(edges):
    """Number of closed loops that directed edges (k, 2) make, each point left once."""
    after = dict(edges.tolist())
    assert len(after) == len(edges)
    count = 0
    while after:
        start, point = after.popitem()
        while point != start:
            point = after.pop(point)
        count += 1
    return count


def normals(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


@pytest.mark.parametrize("steps", [0, 1, 2, 3, 4])
@pytest.mark.parametrize("shape", [with_two_holes, lambda: octahedron(1)], ids=["patch with holes", "closed"])
def test_a_refined_surface_is_a_manifold_with_the_same_boundary_loops(shape, steps):
    points, triangles = shape()
    weights, fine = refine(triangles, len(points), steps)
    edges = directed_edges(fine)
    assert len(np.unique(edges, axis=0)) == len(edges)
    assert loops(boundary(fine)) == loops(boundary(triangles))
    euler = [n - len(np.unique(np.sort(directed_edges(t), axis=1), axis=0)) + len(t)
             for n, t in ((len(points), triangles), (weights.shape[0], fine))]  # fmt: skip
    assert euler[0] == euler[1]
    assert len(np.unique(fine)) == weights.shape[0]


def test_every_two_steps_cut_each_triangle_into_nine_and_each_boundary_edge_into_three():
    points, triangles = with_two_holes()
    _, fine = refine(triangles, len(points), 2)
    assert len(fine) == 9 * len(triangles)
    assert len(boundary(fine)) == 3 * len(boundary(triangles))


@pytest.mark.parametrize("steps", [1, 2, 3, 4])
def test_weights_sum_to_one_also_where_points_belong_to_no_triangle(steps):
    points, triangles = with_two_holes()
    weights, _ = refine(triangles, len(points) + 2, steps)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-14)


def test_old_points_come_first_and_those_of_the_boundary_stay():
    points, triangles = with_two_holes()
    points = points + np.random.default_rng(0).normal(size=points.shape)
    weights, _ = refine(triangles, len(points), 4)
    fixed = np.unique(boundary(triangles))
    np.testing.assert_array_equal((weights @ points)[fixed], points[fixed])


def test_a_flat_regular_patch_becomes_a_finer_regular_patch():
    points, triangles = grid(9, 8)
    weights, fine = refine(triangles, len(points), 2)
    refined = weights @ points
    areas = normals(refined, fine)[:, 2]
    inside = ~np.isin(fine, np.unique(boundary(fine))).any(axis=1)
    np.testing.assert_allclose(areas[inside], np.sqrt(0.75) / 9.0, rtol=1e-12)
    assert (areas > 0.0).all()


def test_linear_fields_are_carried_exactly_inside_a_regular_patch():
    points, triangles = grid(13, 12)
    weights, _ = refine(triangles, len(points), 3)
    middle = np.linalg.norm(points - points.mean(axis=0), axis=1) < 2.5
    field = points @ [0.3, -0.7, 0.0] + 0.2
    np.testing.assert_allclose(((weights @ points) @ [0.3, -0.7, 0.0] + 0.2)[: len(points)][middle], field[middle])


def test_the_boundary_becomes_a_smooth_curve():
    """Twelve points of a circle, for which the four-point scheme is exact up to the third power of the angle."""
    angle = 2.0 * np.pi * np.arange(12) / 12
    points = np.concatenate([np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle]), [[0.0, 0.0, 0.0]]])
    triangles = np.column_stack([np.arange(12), np.roll(np.arange(12), -1), np.full(12, 12)])
    weights, fine = refine(triangles, 13, 6)
    rim = (weights @ points)[np.unique(boundary(fine))]
    sagitta = 1.0 - np.cos(np.pi / 12)
    assert np.abs(np.linalg.norm(rim, axis=1) - 1.0).max() < 0.1 * sagitta


def test_triangles_turn_towards_the_sphere_they_approximate_with_every_step():
    points, triangles = octahedron(3)
    away = []
    for steps in range(5):
        weights, fine = refine(triangles, len(points), steps)
        refined = weights @ points
        outward, middles = normals(refined, fine), refined[fine].mean(axis=1)
        cosine = (outward * middles).sum(axis=1) / np.linalg.norm(outward, axis=1) / np.linalg.norm(middles, axis=1)
        away.append(np.sqrt((np.arccos(np.minimum(cosine, 1.0)) ** 2).mean()))
    assert all(np.diff(away) < 0.0)
    assert away[-1] < 0.6 * away[0]


def test_the_limit_approaches_a_sphere_with_the_square_of_the_coarse_edges():
    """It lies inside, as that of every scheme without negative weights does where a surface is curved."""
    inside = []
    for halvings in (1, 2, 3):
        points, triangles = octahedron(halvings)
        weights, _ = refine(triangles, len(points), 3)
        inside.append(1.0 - np.linalg.norm(weights @ points, axis=1).mean())
    assert all(before / after > 3.4 for before, after in pairwise(inside))


def test_neighbouring_triangles_meet_at_smaller_angles_with_every_step():
    """On a smooth limit the angle falls as the edges do, by the square root of three a step."""
    points, triangles = octahedron(1)
    angles = []
    for steps in (0, 2, 4):
        weights, fine = refine(triangles, len(points), steps)
        unit = normals(weights @ points, fine)
        unit /= np.linalg.norm(unit, axis=1, keepdims=True)
        owner = {(int(a), int(b)): t % len(fine) for t, (a, b) in enumerate(directed_edges(fine))}
        cosines = [unit[t] @ unit[owner[b, a]] for (a, b), t in owner.items()]
        angles.append(np.arccos(min(cosines)))
    assert angles[1] < angles[0] / 2.0
    assert angles[2] < angles[1] / 2.0


def test_the_side_that_faces_out_is_kept():
    points, triangles = octahedron(1)
    for turned, sign in ((triangles, 1.0), (triangles[:, ::-1], -1.0)):
        weights, fine = refine(turned, len(points), 3)
        refined = weights @ points
        assert (sign * (normals(refined, fine) * refined[fine].mean(axis=1)).sum(axis=1) > 0.0).all()


def test_a_boundary_that_meets_itself_is_refused():
    points, triangles = grid(3, 3)
    with pytest.raises(InputError, match="meets itself in point 4"):
        refine(triangles[[1, 6]], len(points), 1)


def test_triangles_that_turn_differently_are_refused():
    points, triangles = grid(3, 3)
    triangles[0] = triangles[0, ::-1]
    with pytest.raises(InputError, match="two triangles run from point"):
        refine(triangles, len(points), 1)
