"""Mean fibre length of every construction against geometry."""

import numpy as np
import pytest

from risorius_offline.muscles.deformation_fibres import DeformationFibres
from risorius_offline.muscles.ellipse import Ellipse
from risorius_offline.muscles.laplace_fibres import LaplaceFibres
from risorius_offline.muscles.polyline_fibres import PolylineFibres
from risorius_offline.muscles.radial_fibres import RadialFibres
from risorius_offline.muscles.ring_fibres import RingFibres
from risorius_offline.muscles.spline_fibres import SplineFibres
from tests.offline.tubes import bar, bent_tube

BAR, _ = bar("hexahedron")


def test_lines_have_the_mean_of_their_lengths():
    lines = (
        np.array([[0.0, 0.0, 0.0], [0.03, 0.0, 0.0], [0.03, 0.04, 0.0]]),
        np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.01]]),
    )
    assert PolylineFibres(lines, 0.006).length(BAR) == pytest.approx(0.04, rel=1e-12)


def test_a_spline_is_as_long_as_the_arc_that_it_goes_through():
    angle = np.linspace(0.0, 0.5 * np.pi, 9)
    arc = 0.03 * np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    assert SplineFibres((arc,), 0.006, 0.006).length(BAR) == pytest.approx(0.5 * np.pi * 0.03, rel=1e-4)


@pytest.mark.parametrize("construction", [LaplaceFibres, DeformationFibres])
@pytest.mark.parametrize("cell_type", ["hexahedron", "wedge", "tetra", "tetra10"])
def test_a_straight_bar_is_as_long_as_its_fibres(construction, cell_type):
    discretisation, region = bar(cell_type)
    assert construction(region).length(discretisation) == pytest.approx(0.03, rel=1e-9)


def test_fibres_of_a_bent_tube_weigh_by_their_flux():
    """Arcs of length pi/2 rho carry a flux of 1 / rho each: the mean is pi/2 times A over the integral of 1 / rho."""
    bend, tube = 0.012, 0.004
    expected = 0.5 * np.pi * tube**2 / (2.0 * (bend - np.sqrt(bend**2 - tube**2)))
    errors = []
    for cells in (4, 8):
        discretisation, region = bent_tube(bend, tube, across=cells, along=4 * cells)
        errors.append(abs(LaplaceFibres(region).length(discretisation) / expected - 1.0))
    assert errors[1] < 0.3 * errors[0]
    assert errors[1] < 2e-3


def test_a_ring_is_as_long_as_its_ellipse_and_radial_lines_as_the_tube_is_wide_on_average():
    ellipse = Ellipse((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.015, 0.025))
    points = ellipse.curve(np.linspace(0.0, 2.0 * np.pi, 2001))[0]
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert RingFibres(ellipse, 0.006).length(BAR) == pytest.approx(chords, rel=1e-6)
    height = np.linspace(-0.006, 0.006, 20001)
    widths = 2.0 * np.sqrt(0.006**2 - height**2)
    assert RadialFibres(ellipse, 0.006).length(BAR) == pytest.approx(widths.mean(), rel=1e-4)
