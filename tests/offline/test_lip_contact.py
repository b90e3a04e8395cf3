"""Contact of a surface with itself: distances, barrier, pairs, steps, and two blocks that press on each other."""

import numpy as np
import pytest
from scipy.optimize import brentq, nnls

from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.discretisation import CellBlock
from risorius_offline.effects.contact_surface import ContactSurface, admitted
from risorius_offline.effects.lip_contact import GAP_TOLERANCE, PRESSURE_AT_HALF_GAP, LipContact, barrier
from risorius_offline.effects.pairs import PairList
from risorius_offline.effects.point_triangle import (
    TRIANGLE,
    add_gradient,
    add_hessian,
    closest_point,
    safe_fraction,
)
from risorius_offline.full_model import FullModel
from risorius_offline.newton import GuardedNewton, SolverReport
from tests.offline.meshes import box

RIGHT_TRIANGLE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
# A point over every region of the right triangle, its closest point and its distance.
REGIONS = {
    "face": ((0.2, 0.3, 0.5), (0.2, 0.3, 0.0), 0.5),
    "edge on y = 0": ((0.4, -0.3, 0.4), (0.4, 0.0, 0.0), 0.5),
    "slanted edge": ((0.8, 0.8, 0.0), (0.5, 0.5, 0.0), 0.3 * np.sqrt(2.0)),
    "edge on x = 0": ((-0.4, 0.6, 0.3), (0.0, 0.6, 0.0), 0.5),
    "first corner": ((-1.0, -2.0, 2.0), (0.0, 0.0, 0.0), 3.0),
    "second corner": ((3.0, -1.0, 2.0), (1.0, 0.0, 0.0), 3.0),
    "third corner": ((-2.0, 3.0, 1.0), (0.0, 1.0, 0.0), 3.0),
}


def distance(x, feature=TRIANGLE):
    w = np.empty(3)
    return closest_point(x, feature, w), w


@pytest.mark.parametrize("region", REGIONS)
def test_distance_in_every_region_of_a_triangle(region):
    point, foot, expected = REGIONS[region]
    found, w = distance(np.vstack([point, RIGHT_TRIANGLE]))
    assert found == pytest.approx(expected, rel=1e-14)
    np.testing.assert_allclose(w @ RIGHT_TRIANGLE, foot, atol=1e-14)


def test_distance_agrees_with_non_negative_least_squares():
    """min |p - sum w t| over w >= 0, sum w = 1, the sum as one heavy row."""
    rng = np.random.default_rng(0)
    for x in rng.normal(size=(300, 4, 3)):
        heavy = 1e5
        w, _ = nnls(np.vstack([x[1:].T, np.full(3, heavy)]), np.append(x[0], heavy))
        assert distance(x)[0] == pytest.approx(np.linalg.norm(x[0] - w @ x[1:]), rel=1e-7)


def test_distance_to_a_triangle_without_area_is_that_to_its_longest_edge():
    flat = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    for point, expected in (((1.5, 3.0, 4.0), 5.0), ((-3.0, 4.0, 0.0), 5.0)):
        assert distance(np.vstack([point, flat]))[0] == pytest.approx(expected, rel=1e-14)


def gradient_of(x, slope, feature):
    gradient = np.zeros(12)
    add_gradient(x, distance(x, feature)[1], slope(distance(x, feature)[0]), gradient)
    return gradient


@pytest.mark.parametrize("region", REGIONS)
def test_derivatives_agree_with_finite_differences(region):
    """Of d^3, so that slope and curvature both count; the triangle is turned out of its plane."""
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    x = np.vstack([REGIONS[region][0], RIGHT_TRIANGLE]) @ turn + 0.1
    d, w = distance(x)
    hessian = np.zeros((12, 12))
    add_hessian(x, w, 3.0 * d**2, 6.0 * d, hessian)
    h = 1e-5
    steps = h * np.eye(12).reshape(12, 4, 3)
    differences = [(distance(x + s)[0] ** 3 - distance(x - s)[0] ** 3) / (2.0 * h) for s in steps]
    gradient = gradient_of(x, lambda d: 3.0 * d**2, TRIANGLE)
    np.testing.assert_allclose(gradient, differences, atol=1e-7 * np.abs(gradient).max())
    slopes = [[gradient_of(x + k * s, lambda d: 3.0 * d**2, TRIANGLE) for k in (1, -1)] for s in steps]
    rows = [(up - down) / (2.0 * h) for up, down in slopes]
    np.testing.assert_allclose(hessian, rows, atol=1e-7 * np.abs(hessian).max())


def test_barrier_begins_with_continuous_curvature_and_rises_without_bound():
    gap = 0.2e-3
    begin = np.array(barrier(gap * (1.0 - 1e-7), gap)) / [gap**2, gap, 1.0]
    np.testing.assert_allclose(begin, 0.0, atol=1e-6)
    for d in (0.01 * gap, 0.5 * gap, 0.9 * gap):
        h = 1e-6 * gap
        value, slope, curvature = barrier(d, gap)
        assert slope == pytest.approx((barrier(d + h, gap)[0] - barrier(d - h, gap)[0]) / (2 * h), rel=1e-6)
        assert curvature == pytest.approx((barrier(d + h, gap)[1] - barrier(d - h, gap)[1]) / (2 * h), rel=1e-6)
        assert value > 0 > slope
    assert barrier(1e-300, gap)[0] > 600 * gap**2


def two_blocks(lower=(4, 4, 2), upper=(4, 4, 2), size=0.02, gap=1e-3):
    """One mesh of two cubes over each other with a gap between; bone is the far end of each."""
    (a, below), (b, above) = box("hexahedron", lower, (size,) * 3), box("hexahedron", upper, (size,) * 3)
    points = np.concatenate([a, b + np.array([0.0, 0.0, size + gap])])
    cells = np.concatenate([below.connectivity, len(a) + above.connectivity])
    return Anatomy(
        name="two blocks",
        points=points,
        cells=(CellBlock("hexahedron", cells, np.zeros(len(cells), dtype=np.int64)),),
        materials=(Yeoh.neo_hookean(15e3, 0.45),),
        skull=np.isclose(points[:, 2], 0.0),
        jaw=np.isclose(points[:, 2], points[:, 2].max()),
        skin=np.zeros((0, 3), dtype=np.int64),
        muscles=(),
        jaw_motion=None,
    )


def crumpled_contact(seed=0):
    """Blocks of different meshes with random displacement, pressed to a mean gap of 40 % of the tolerance."""
    anatomy = two_blocks((3, 3, 2), (4, 4, 2))
    upper = anatomy.points[:, 2] > 0.0205
    u = np.random.default_rng(seed).uniform(-1.0, 1.0, anatomy.points.shape) * 0.03e-3
    u[upper] += [0.4e-3, 0.7e-3, -1e-3 + 0.4 * GAP_TOLERANCE]
    return anatomy, LipContact(anatomy), u


def forces_of(effect, u):
    forces = np.zeros_like(u)
    energy = effect.add_forces(u, forces)
    return energy, forces


def assembled(blocks, count):
    matrix = np.zeros((3 * count, 3 * count))
    for nodes, block in zip(blocks.nodes, blocks.matrices, strict=True):
        dofs = (3 * nodes[:, None] + np.arange(3)).ravel()
        np.add.at(matrix, np.ix_(dofs, dofs), block)
    return matrix


def test_forces_and_second_derivatives_of_the_effect_agree_with_finite_differences():
    _, effect, u = crumpled_contact()
    energy, forces = forces_of(effect, u)
    assert energy == pytest.approx(effect.energy(u), rel=1e-14)
    stiffness = assembled(effect.second_derivatives(u, project=False), len(u))
    np.testing.assert_allclose(stiffness, stiffness.T, atol=1e-12 * np.abs(stiffness).max())
    rng = np.random.default_rng(1)
    for _ in range(4):
        direction = rng.normal(size=u.shape)
        h = 1e-10
        up, down = (forces_of(effect, u + s * h * direction) for s in (1, -1))
        assert (up[0] - down[0]) / (2 * h) == pytest.approx(np.sum(forces * direction), rel=1e-6)
        change = (up[1] - down[1]).ravel() / (2 * h)
        np.testing.assert_allclose(stiffness @ direction.ravel(), change, atol=1e-5 * np.abs(change).max())


def test_projected_second_derivatives_are_positive_semi_definite_and_others_are_not():
    _, effect, u = crumpled_contact()
    lowest = {
        project: min(np.linalg.eigvalsh(m)[0] / np.abs(m).max() for m in matrices)
        for project, matrices in ((p, effect.second_derivatives(u, project=p).matrices) for p in (False, True))
    }
    assert lowest[True] > -1e-12
    assert lowest[False] < -1e-3


def test_contact_forces_are_in_balance_and_do_not_see_a_rigid_motion():
    anatomy, effect, u = crumpled_contact()
    energy, forces = forces_of(effect, u)
    x = anatomy.points + u
    size = np.abs(forces).sum()
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-12 * size)
    np.testing.assert_allclose(np.cross(x, forces).sum(axis=0), 0.0, atol=1e-12 * size * np.abs(x).max())
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    moved_energy, moved = forces_of(effect, np.ascontiguousarray(x @ turn.T + [0.1, 0.2, 0.3] - anatomy.points))
    assert energy > 0
    assert moved_energy == pytest.approx(energy, rel=1e-9)
    np.testing.assert_allclose(moved, forces @ turn.T, atol=1e-9 * np.abs(forces).max())


def test_a_node_slides_over_edges_and_corners_of_a_flat_face_without_a_bump():
    """Half of the node's area times the barrier of its height, wherever edges and corners lie beneath it."""
    plate, cells = box("tetra", (3, 3, 1), (0.03, 0.03, 0.01))
    apex = len(plate)
    above = np.array([[0.0, 0.0, 0.0], [0.004, 0.0, 0.004], [0.0, 0.004, 0.004], [-0.003, -0.003, 0.004]])
    points = np.concatenate([plate, above + np.array([0.01, 0.01, 0.011])])
    connectivity = np.vstack([cells.connectivity, apex + np.array([[0, 2, 1, 3]])])
    plate_is_bone = np.arange(len(points)) < apex
    no_jaw = np.zeros(len(points), dtype=bool)
    block = CellBlock("tetra", connectivity, np.zeros(len(connectivity), dtype=np.int64))
    skin = np.zeros((0, 3), dtype=np.int64)
    tissue = (Yeoh.neo_hookean(15e3, 0.45),)
    anatomy = Anatomy("apex", points, (block,), tissue, plate_is_bone, no_jaw, skin, (), None)
    effect = LipContact(anatomy)
    height = 0.5 * GAP_TOLERANCE
    found = []
    for along in np.linspace(0.3e-3, 9.7e-3, 95):
        u = np.zeros_like(points)
        u[apex:] = [along, along + 0.1e-3, height - 1e-3]  # next to a diagonal, and across all the others
        found.append(effect.energy(u))
    value, slope, _ = barrier(height, GAP_TOLERANCE)
    area = ContactSurface.of(anatomy).areas[-4]
    expected = 0.5 * area * PRESSURE_AT_HALF_GAP / -slope * value
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def brute_force(surface, x, reach):
    """All admitted pairs nearer than reach."""
    return {
        (p, t)
        for t, corners in enumerate(surface.triangles)
        for p in np.flatnonzero((np.abs(x - x[corners[0]]) < reach + 0.02).all(axis=1))
        if admitted(p, t, surface.triangles, surface.bone) and distance(x[[p, *corners]])[0] < reach
    }


def test_kept_list_never_misses_a_pair_while_nodes_wander():
    surface = ContactSurface.of(two_blocks((3, 3, 2), (4, 4, 2)))
    reach = 1.5e-3
    pairs = PairList(surface, np.arange(len(surface.nodes)), reach, margin=1e-3)
    rng = np.random.default_rng(4)
    x, kept = surface.points, 0
    last = None
    for _ in range(12):
        x = x + rng.normal(size=x.shape) * 0.07e-3
        found = pairs.at(x)
        kept += found is last
        last = found
        listed = [tuple(pair) for pair in found]
        assert len(set(listed)) == len(listed)
        assert brute_force(surface, x, reach) <= set(listed)
    assert 0 < kept < 11


def test_pairs_of_a_motion_are_those_that_come_near_on_the_way():
    surface = ContactSurface.of(two_blocks((2, 2, 1), (3, 3, 1)))
    motion = np.random.default_rng(5).normal(size=surface.points.shape) * 4e-3
    listed = {
        tuple(pair)
        for pair in PairList(surface, np.arange(len(surface.nodes)), 0.5e-3, 0.0).swept(surface.points, motion)
    }
    for time in np.linspace(0.0, 1.0, 9):
        assert brute_force(surface, surface.points + time * motion, 0.5e-3) <= listed


def first_contact(x, v):
    """Earliest time in [0, 1] at which the point lies in the triangle: roots of the cubic of coplanarity."""
    times = np.linspace(0.0, 1.0, 4)
    volume = [np.linalg.det((x + t * v)[1:] - (x + t * v)[0]) for t in times]
    roots = np.roots(np.polyfit(times, volume, 3))
    real = np.sort(roots[np.abs(roots.imag) < 1e-9].real)
    for t in real[(real >= 0.0) & (real <= 1.0)]:
        if distance(x + t * v)[0] < 1e-7:
            return t
    return np.inf


def test_safe_fraction_never_passes_through_and_seldom_stops_early():
    rng = np.random.default_rng(6)
    hits, early = 0, 0
    for _ in range(4000):
        x, v = rng.normal(size=(4, 3)), rng.normal(size=(4, 3)) * 3.0
        v[0] -= 2.0 * (x[0] - x[1:].mean(axis=0))
        start = distance(x)[0]
        fraction = safe_fraction(x, v, 0.1, 1.0)
        contact = first_contact(x, v)
        hits += contact <= 1.0
        assert 0.0 < fraction <= 1.0
        assert fraction < contact
        way = [distance(x + t * v)[0] for t in np.linspace(0.0, fraction, 50)]
        assert min(way) >= 0.1 * start * (1.0 - 1e-9)
        # Stopped, the pair is near the share that it keeps: nothing of the motion is given away.
        early += fraction < 1.0 and way[-1] > 0.102 * start
    assert hits > 400
    assert early == 0


def test_safe_fraction_of_motion_along_away_and_in_step_is_all_of_it():
    x = np.vstack([[0.3, 0.3, 1e-4], RIGHT_TRIANGLE])
    for point, triangle in (((5.0, 3.0, 0.0), 0.0), ((0.0, 0.0, 7.0), 0.0), ((3.0, 2.0, -9.0), (3.0, 2.0, -9.0))):
        v = np.zeros((4, 3))
        v[0], v[1:] = point, triangle
        assert safe_fraction(x, v, 0.1, 1.0) == 1.0
    v[0], v[1:] = (0.0, 0.0, -1.0), 0.0
    assert safe_fraction(x, v, 0.1, 1.0) == pytest.approx(0.9e-4, rel=1e-9)
    edge_on = np.vstack([[-1.0, 0.2, 0.0], RIGHT_TRIANGLE])  # in the triangle's plane, where coplanarity tells nothing
    v[0] = (5.0, 0.0, 0.0)
    assert safe_fraction(edge_on, v, 0.1, 1.0) == pytest.approx(0.18, rel=1e-9)


def test_largest_step_stops_a_block_that_would_fly_through_the_other():
    anatomy = two_blocks()
    effect, rest = LipContact(anatomy), np.zeros_like(anatomy.points)
    upper = anatomy.points[:, 2] > 0.0205
    through = np.where(upper[:, None], [0.0, 0.0, -0.1], 0.0)
    fraction = effect.largest_step(rest, through)
    assert 0.0 < 1e-3 - 0.1 * fraction <= 1e-4 * 1.1
    assert effect.largest_step(rest, -through) == 1.0
    assert effect.largest_step(rest, np.full_like(rest, 0.03)) == 1.0
    assert effect.largest_step(rest, -1e6 * through) == pytest.approx(0.2e-5)


def test_a_state_on_the_other_side_of_a_surface_is_not_admitted():
    anatomy = two_blocks()
    effect = LipContact(anatomy)
    upper = anatomy.points[:, 2] > 0.0205
    through = np.where(upper[:, None], [0.0, 0.0, -0.1], 0.0)
    assert np.isfinite(effect.energy(through))
    assert not effect.admits(through)
    assert effect.admits(-through)


def pressed(lower, upper, down):
    """Force (N) and smallest gap of blocks that may slide along their far ends, the upper end moved down."""
    anatomy = two_blocks(lower, upper)
    effect = LipContact(anatomy)
    model = FullModel(anatomy, [effect])
    points = anatomy.points
    held = np.zeros(points.shape, dtype=bool)
    held[:, 2] = anatomy.skull | anatomy.jaw
    held[:, :2] |= points[:, :2] == 0.0  # two planes of symmetry let the blocks widen freely
    model.free, model.prescribed = np.flatnonzero(~held), np.flatnonzero(held)
    model.set_parameters(np.zeros(0))
    u = np.zeros_like(points)
    top = points[:, 2] > 0.0205
    u[top, 2] = 0.5 * GAP_TOLERANCE - 1e-3
    for end in np.linspace(-1e-3, -down, 4):
        u[anatomy.jaw, 2] = end
        u = GuardedNewton(1e-6, 80).minimise(model, u, SolverReport())
        assert u is not None
    forces = model.forces(u)[2]
    return -forces[anatomy.jaw, 2].sum(), effect.smallest_gap(u)


def uniaxial_force(stretch, size=0.02):
    """Force (N) on a neo-Hookean block of our material at a stretch, sides free."""
    material = Yeoh.neo_hookean(15e3, 0.45)
    shear, lame = 2.0 * material.c10, material.lame
    lateral = brentq(lambda s: shear * (s - 1.0 / s) + lame * np.log(stretch * s * s) / s, 0.8, 1.5, xtol=1e-14)
    along = shear * (stretch - 1.0 / stretch) + lame * np.log(stretch * lateral**2) / stretch
    return -along * size**2


@pytest.mark.parametrize(("lower", "upper"), [((3, 3, 2), (3, 3, 2)), ((2, 2, 2), (3, 3, 2))])
def test_blocks_press_on_each_other_with_the_stress_of_their_compression(lower, upper):
    """Theory at the two gaps that the contact may have, none and the tolerance, brackets the force."""
    down = 4e-3
    force, gap = pressed(lower, upper, down)
    touching, apart = (uniaxial_force(1.0 - (down - 1e-3 + left) / 0.04) for left in (0.0, GAP_TOLERANCE))
    assert touching < force < apart
    assert 0.0 < gap < GAP_TOLERANCE


def test_only_nodes_in_the_folds_of_the_mouth_corners_see_nothing(published_face):
    """The published mesh crosses itself by 15 micrometres at both corners; these nodes are within 1.5 mm of them."""
    blind = ContactSurface.of(published_face).points[LipContact(published_face).blind]
    assert 0 < len(blind) <= 4
    corner = np.array([0.0233, -0.0725, -0.0068])
    np.testing.assert_allclose(np.abs(blind) * np.sign([1, -1, -1]), np.tile(corner, (len(blind), 1)), atol=1.5e-3)


def test_published_face_at_rest_is_free_of_contact(published_face):
    effect, rest = LipContact(published_face), np.zeros_like(published_face.points)
    energy, forces = forces_of(effect, rest)
    assert energy == 0.0
    assert not forces.any()
    assert len(effect.second_derivatives(rest, project=False).nodes) == 0
    assert effect.smallest_gap(rest) == np.inf


def test_lips_of_the_published_face_stop_each_other(published_face):
    """The lower lip, moved up rigidly by 10 mm, is stopped within the 1 mm that there is between the lips."""
    points = published_face.points
    lower = (points[:, 1] < -0.0725) & (np.abs(points[:, 0]) < 0.015) & (points[:, 1] > -0.085)
    up = np.where(lower[:, None], [0.0, 0.01, 0.0], 0.0)
    assert LipContact(published_face).largest_step(np.zeros_like(points), up) < 0.2
