"""Fibres along given lines: polylines and B-splines."""

import numpy as np
import pytest

from risorius.errors import InputError
from risorius_offline.discretisation import Discretisation
from risorius_offline.muscles.fibres import volume_positions
from risorius_offline.muscles.polyline_fibres import PolylineFibres
from risorius_offline.muscles.spline_fibres import SplineFibres
from tests.offline.meshes import box
from tests.offline.tubes import angles

BEND = 0.02


def plate():
    points, cells = box("hexahedron", cells=(24, 24, 3), size=(0.03, 0.03, 0.004))
    return Discretisation(points, [cells])


def arc(count, start=0.1, end=1.4):
    """Points on a circle about the plate's corner, in its middle plane."""
    angle = np.linspace(start, end, count)
    return BEND * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)]) + [0.0, 0.0, 0.002]


def spline_error(discretisation, count):
    """Largest angle between spline fibres and the circle, away from the line's ends."""
    field = SplineFibres((arc(count),), 0.003, 0.003).field(discretisation)
    x, y, _ = volume_positions(discretisation)[field.points].T
    angle = np.arctan2(y, x)
    within = (angle > 0.1) & (angle < 1.4)
    exact = np.column_stack([np.sin(angle), -np.cos(angle), np.zeros_like(angle)])
    assert within.sum() > 1000
    return angles(field.directions[within], exact[within]).max()


def test_spline_tangents_converge_to_those_of_a_circle_with_the_third_order():
    """Floater and Surazhsky 2006: interpolation at chord lengths is of fourth order, its derivative of third."""
    discretisation = plate()
    coarse, fine = (spline_error(discretisation, count) for count in (7, 13))
    assert fine < 0.05
    assert np.log2(coarse / fine) > 2.7


def test_spline_takes_the_tissue_within_its_radius():
    """Of a circle, whose distance is known; the spline through 33 points is nearer to it than a micrometre."""
    discretisation = plate()
    positions = volume_positions(discretisation)
    angle = np.arctan2(positions[:, 1], positions[:, 0])
    distance = np.hypot(np.hypot(positions[:, 0], positions[:, 1]) - BEND, positions[:, 2] - 0.002)
    found = np.isin(np.arange(len(positions)), SplineFibres((arc(33),), 0.003, 0.003).field(discretisation).points)
    within = (angle > 0.1) & (angle < 1.4) & (np.abs(distance - 0.003) > 1e-6)
    np.testing.assert_array_equal(found[within], distance[within] < 0.003)


@pytest.mark.parametrize("count", [2, 3, 5])
def test_straight_spline_has_a_radius_that_goes_linearly_from_origin_to_insertion(count):
    discretisation = plate()
    line = np.linspace([0.004, 0.015, 0.002], [0.026, 0.015, 0.002], count)
    field = SplineFibres((line,), 0.002, 0.008).field(discretisation)
    x, y, z = volume_positions(discretisation).T
    along = (x - 0.004) / 0.022
    within = (along > 0.0) & (along < 1.0)
    expected = np.hypot(y - 0.015, z - 0.002) <= 0.002 + 0.006 * along
    found = np.isin(np.arange(len(x)), field.points)
    np.testing.assert_array_equal(found[within], expected[within])
    np.testing.assert_allclose(field.directions, np.tile([-1.0, 0.0, 0.0], (len(field.points), 1)), atol=1e-12)


def test_polyline_fibres_point_from_the_insertion_to_the_origin():
    discretisation = plate()
    line = np.array([[0.004, 0.015, 0.002], [0.004, 0.015, 0.002], [0.02, 0.015, 0.002]])
    field = PolylineFibres((line,), 0.003).field(discretisation)
    np.testing.assert_allclose(field.directions, np.tile([-1.0, 0.0, 0.0], (len(field.points), 1)))


@pytest.mark.parametrize(
    "construction", [lambda lines: PolylineFibres(lines, 0.002), lambda lines: SplineFibres(lines, 0.004, 0.002)]
)
def test_insertion_end_is_the_mean_end_of_the_lines(construction):
    fan = tuple(np.array([[0.0, 0.01, 0.0], [0.02, 0.01 + side, 0.0]]) for side in (-0.004, 0.004))
    end = construction(fan).insertion_end(plate())
    np.testing.assert_allclose(end.point, [0.02, 0.01, 0.0])
    np.testing.assert_allclose(end.direction, [1.0, 0.0, 0.0], atol=1e-15)
    assert end.radius == 0.002


def test_lines_without_tissue_and_repeated_points_are_refused():
    away = (np.array([[0.1, 0.0, 0.0], [0.1, 0.1, 0.0]]),)
    for fibres in (PolylineFibres(away, 0.006), SplineFibres(away, 0.003, 0.006)):
        with pytest.raises(
            InputError, match=r"no tissue within its radius of 6 mm; check its coordinates, its units or"
        ):
            fibres.field(plate())
    with pytest.raises(InputError, match=r"line 0 has the same point twice in a row; leave one of them out"):
        SplineFibres((np.zeros((3, 3)),), 0.003, 0.003)
