"""Sphincters: rings of fibres, and ellipses that contract along their radial directions (Figure 7.10)."""

import numpy as np
import pytest

from risorius.errors import InputError
from risorius_offline.discretisation import Discretisation
from risorius_offline.muscles.assembly import dead_loads
from risorius_offline.muscles.ellipse import Ellipse
from risorius_offline.muscles.fibres import volume_positions
from risorius_offline.muscles.loads import ForceDensity
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.radial_fibres import RadialFibres
from risorius_offline.muscles.ring_fibres import RingFibres
from tests.offline.meshes import box

CENTRE = np.array([0.03, 0.02, 0.006])
LIPS = Ellipse(tuple(CENTRE), (0.0, 0.0, 2.0), (3.0, 0.0, 1.0), (0.02, 0.012))


@pytest.fixture(scope="module")
def plate():
    points, cells = box("hexahedron", cells=(24, 16, 4), size=(0.06, 0.04, 0.012))
    return Discretisation(points, [cells])


def test_fibres_of_a_round_ring_are_exactly_tangential(plate):
    circle = Ellipse(tuple(CENTRE), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.015, 0.015))
    field = RingFibres(circle, 0.004).field(plate)
    offset = volume_positions(plate) - CENTRE
    radius = np.hypot(offset[:, 0], offset[:, 1])
    np.testing.assert_array_equal(
        np.sort(field.points), np.flatnonzero(np.hypot(radius - 0.015, offset[:, 2]) <= 0.004)
    )
    x, y = (offset / radius[:, None])[field.points, :2].T
    np.testing.assert_allclose(field.directions, np.column_stack([-y, x, np.zeros_like(x)]), atol=1e-12)


def test_fibres_of_an_elliptic_ring_are_perpendicular_to_the_way_to_the_ellipse(plate):
    """The closest point of a smooth curve lies along its normal: found here by brute force over a million angles."""
    field = RingFibres(LIPS, 0.004).field(plate)
    dense = np.linspace(0.0, 2.0 * np.pi, 1_000_000)
    curve = CENTRE[:2] + np.column_stack([0.02 * np.cos(dense), 0.012 * np.sin(dense)])
    for point, direction in list(zip(field.points, field.directions, strict=True))[::200]:
        position = volume_positions(plate)[point]
        squared = ((curve - position[:2]) ** 2).sum(axis=1)
        angle = dense[squared.argmin()]
        assert np.sqrt(squared.min() + (position[2] - CENTRE[2]) ** 2) <= 0.004 + 1e-9
        tangent = np.array([-0.02 * np.sin(angle), 0.012 * np.cos(angle), 0.0])
        np.testing.assert_allclose(direction, tangent / np.linalg.norm(tangent), atol=1e-4)


def test_ring_is_the_same_wherever_its_angle_starts(plate):
    """A quarter turn of the axes moves the seam of the angle; every point keeps its direction."""
    turned = Ellipse(tuple(CENTRE), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (0.012, 0.02))
    one, other = (RingFibres(ellipse, 0.004).field(plate) for ellipse in (LIPS, turned))
    np.testing.assert_array_equal(one.points, other.points)
    np.testing.assert_allclose(one.directions, other.directions, atol=1e-10)


def test_radial_fibres_point_to_the_centre_in_the_plane_of_the_ellipse(plate):
    field = RadialFibres(LIPS, 0.004).field(plate)
    towards = (CENTRE - volume_positions(plate)[field.points]) * [1.0, 1.0, 0.0]
    np.testing.assert_array_equal(field.points, RingFibres(LIPS, 0.004).field(plate).points)
    np.testing.assert_allclose(field.directions, towards / np.linalg.norm(towards, axis=1, keepdims=True), atol=1e-12)


def test_radial_load_is_in_balance_and_pulls_inwards(plate):
    """The plate and the ellipse have the same two planes of symmetry."""
    muscle = Muscle("orbicularis_oris", RadialFibres(LIPS, 0.004), ForceDensity(1e6))
    forces = dead_loads(plate, [muscle]).reshape(-1, 3)
    assert (forces * (CENTRE - plate.points))[:, :2].sum() > 0.0
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-12 * np.abs(forces).sum())


def test_bad_sphincters_are_refused_with_the_remedy(plate):
    with pytest.raises(InputError, match=r"normal \(0, 0, 1\) and first axis \(0, 0, 2\) are parallel or zero; give a"):
        Ellipse((0, 0, 0), (0, 0, 1), (0, 0, 2), (0.02, 0.01))
    with pytest.raises(
        InputError, match=r"radius of 12 mm reaches its centre \(semi-axes 20 and 12 mm\); give a smaller"
    ):
        RadialFibres(LIPS, 0.012)
    with pytest.raises(InputError, match=r"muscle 'oo': a force density along a ring turns the tissue .*give it an"):
        Muscle("oo", RingFibres(LIPS, 0.004), ForceDensity(1e6))
    with pytest.raises(InputError, match=r"no tissue within its radius of 4 mm"):
        RingFibres(Ellipse((1.0, 0.0, 0.0), (0, 0, 1), (1, 0, 0), (0.02, 0.01)), 0.004).field(plate)
    for fibres in (RingFibres(LIPS, 0.004), RadialFibres(LIPS, 0.004)):
        with pytest.raises(InputError, match="has no insertion; leave the insertion cone out"):
            fibres.insertion_end(plate)
