"""Fibres from the cells of a muscle: the Laplace problem (7.6) and the elastic test deformation (7.7)."""

from dataclasses import replace

import meshio
import numpy as np
import pytest
import skfem
from skfem.helpers import ddot, div, grad
from skfem.io.meshio import from_meshio

from risorius.errors import InputError
from risorius_offline.anatomy.nested_cylinders import INNER_RADIUS, nested_cylinders
from risorius_offline.discretisation import Discretisation
from risorius_offline.elements import ELEMENTS
from risorius_offline.muscles.deformation_fibres import DeformationFibres
from risorius_offline.muscles.fibres import volume_positions
from risorius_offline.muscles.laplace_fibres import LaplaceFibres
from tests.offline.tubes import angles, bar, bent_tube

CONSTRUCTIONS = [LaplaceFibres, DeformationFibres]


@pytest.fixture(scope="module")
def cylinders():
    anatomy = nested_cylinders()
    return Discretisation(anatomy.points, anatomy.cells), anatomy.muscles[0].fibres.region


@pytest.mark.parametrize("construction", CONSTRUCTIONS)
def test_fibres_of_the_nested_cylinders_are_axial_in_the_whole_inner_cylinder(cylinders, construction):
    """Figure 7.7."""
    discretisation, region = cylinders
    field = construction(region).field(discretisation)
    positions = volume_positions(discretisation)
    np.testing.assert_array_equal(
        np.sort(field.points), np.flatnonzero(np.hypot(positions[:, 0], positions[:, 2]) < INNER_RADIUS)
    )
    assert angles(field.directions, [0.0, -1.0, 0.0]).max() < 1.0  # from the insertion, the top, to the fixed bottom


@pytest.mark.parametrize("construction", CONSTRUCTIONS)
@pytest.mark.parametrize("cell_type", sorted(ELEMENTS))
def test_fibres_of_a_straight_bar_are_exactly_straight_on_a_distorted_mesh(cell_type, construction):
    """psi and tau are linear and constant then, and in the space of every element."""
    discretisation, region = bar(cell_type)
    field = construction(region).field(discretisation)
    assert len(field.points) == len(volume_positions(discretisation))
    np.testing.assert_allclose(field.directions, np.tile([-1.0, 0.0, 0.0], (len(field.points), 1)), atol=1e-12)


@pytest.mark.parametrize("construction", CONSTRUCTIONS)
def test_a_region_one_cell_long_has_fibres_though_no_node_is_free(construction):
    discretisation, region = bar("hexahedron", cells=(1, 2, 2), distortion=0.0)
    directions = construction(region).field(discretisation).directions
    np.testing.assert_allclose(directions, np.tile([-1.0, 0.0, 0.0], (len(directions), 1)), atol=1e-12)


def arc_directions(discretisation):
    positions = volume_positions(discretisation)
    angle = np.arctan2(positions[:, 1], positions[:, 0])
    return np.column_stack([np.sin(angle), -np.cos(angle), np.zeros_like(angle)]), angle


def test_laplace_fibres_of_a_bent_tube_follow_its_arc():
    """psi is the angle about the axis of the torus, which is harmonic and has no flux through the tube."""
    discretisation, region = bent_tube(0.02)
    field = LaplaceFibres(region).field(discretisation)
    assert angles(field.directions, arc_directions(discretisation)[0][field.points]).max() < 1e-6


def test_deformation_fibres_of_a_bent_tube_follow_its_arc_away_from_the_ends():
    """By Saint-Venant's principle the tube slides along itself like a rigid body, a rotation about the axis of the
    torus; the uniform data of the ends differ from that by the ratio of tube to bend, 0.1, and the difference dies out
    within some diameters. The middle half begins two diameters from the ends.
    """
    discretisation, region = bent_tube(0.04)
    field = DeformationFibres(region).field(discretisation)
    arc, angle = arc_directions(discretisation)
    deviation = angles(field.directions, arc[field.points])
    middle = np.abs(angle[field.points] - 0.25 * np.pi) < 0.125 * np.pi
    assert deviation.max() < np.degrees(0.1)
    assert deviation[middle].max() < 0.05


@pytest.mark.parametrize("cell_type", ["hexahedron", "tetra"])
def test_test_deformation_with_a_fixed_capsule_agrees_with_scikit_fem(cell_type):
    """The boundary value problem (7.7) as printed, in its own weak form; affine cells, where quadrature is exact."""
    discretisation, region = bar(cell_type, cells=(8, 4, 4), distortion=0.0)
    found = DeformationFibres(region, poisson=0.4, capsule="fixed").tangents(discretisation)
    connectivity = discretisation.volumes[0].cells.connectivity
    mesh = from_meshio(meshio.Mesh(discretisation.points, [(cell_type, connectivity)]))
    element = {"hexahedron": skfem.ElementHex1(), "tetra": skfem.ElementTetP1()}[cell_type]
    basis = skfem.Basis(mesh, skfem.ElementVector(element), intorder=2)

    @skfem.BilinearForm
    def seed(tau, v, w):
        return (1.0 - 2.0 * 0.4) * ddot(grad(tau), grad(v)) + div(tau) * div(v)

    tau = np.zeros(basis.N)
    at_ends = np.isin(mesh.p[0], [0.0, mesh.p[0].max()])
    tau[basis.nodal_dofs[0, at_ends]] = -1.0
    expected = skfem.solve(*skfem.condense(seed.assemble(basis), x=tau, D=basis.get_dofs()))[basis.nodal_dofs].T
    np.testing.assert_allclose(found, expected, atol=1e-10)
    assert np.abs(expected[:, 1:]).max() > 1e-3  # the flow of (7.7) as printed is not parallel to the bar


def test_points_where_the_field_has_died_out_are_left_passive():
    """Origin and insertion face each other across one end of a bar, 6 mm high: along the bar the field decays like
    exp(-pi x / 6 mm), to below 1e-6 of its largest value within 27 mm.
    """
    discretisation, region = bar("hexahedron", size=(0.06, 0.006, 0.006), cells=(24, 2, 2), distortion=0.0)
    x, _, z = discretisation.points.T
    near = x < 0.0101
    across = replace(region, origin=np.flatnonzero(near & (z == 0.0)), insertion=np.flatnonzero(near & (z == z.max())))
    active = np.isin(
        np.arange(len(volume_positions(discretisation))), LaplaceFibres(across).field(discretisation).points
    )
    along = volume_positions(discretisation)[:, 0]
    assert active[along < 0.02].all()
    assert not active[along > 0.045].any()


@pytest.mark.parametrize("cell_type", sorted(ELEMENTS))
def test_insertion_end_is_the_centre_and_normal_of_the_insertion(cell_type):
    discretisation, region = bar(cell_type)
    end = LaplaceFibres(region).insertion_end(discretisation)
    np.testing.assert_allclose(end.point, [0.03, 0.004, 0.003], atol=1e-12)
    np.testing.assert_allclose(end.direction, [1.0, 0.0, 0.0], atol=1e-12)
    assert np.pi * end.radius**2 == pytest.approx(0.008 * 0.006)


def without_face(region, discretisation):
    return replace(region, insertion=region.insertion[:1])


def touching(region, discretisation):
    return replace(region, insertion=np.flatnonzero(np.isclose(discretisation.points[:, 1], 0.0)))


def cut_in_two(region, discretisation):
    middle = volume_positions(discretisation)[:, 0].reshape(-1, 8).mean(axis=1)
    return replace(region, cells={"hexahedron": np.flatnonzero(np.abs(middle - 0.015) > 0.005)})


def without_cells(region, discretisation):
    return replace(region, cells={"wedge": np.array([0])})


def pinched(region, discretisation):
    """Two columns of cells that share an edge."""
    _, y, z = volume_positions(discretisation).reshape(-1, 8, 3).mean(axis=1).T
    return replace(region, cells={"hexahedron": np.flatnonzero((y < 0.004) == (z < 0.003))})


@pytest.mark.parametrize("construction", CONSTRUCTIONS)
@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (without_face, r"no face of its region's surface has all its nodes in the insertion; mark the nodes of whole"),
        (touching, r"its origin and insertion share 3 node\(s\), first 0; part them"),
        (cut_in_two, r"the part of its region around node \d+ has no origin; mark one or leave the part out"),
        (pinched, r"its region is pinched to a point or an edge at node \d+; add cells around it"),
        (without_cells, r"its region has no cells; mark the muscle's cells"),
    ],
)
def test_bad_region_is_refused_with_item_and_remedy(construction, spoil, message):
    discretisation, region = bar("hexahedron", distortion=0.0)
    with pytest.raises(InputError, match=message):
        construction(spoil(region, discretisation)).field(discretisation)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"poisson": 0.5}, r"Poisson's ratio 0.5; give a number in \[0, 0.5\)"),
        ({"capsule": "loose"}, r"capsule 'loose'; write one of sliding, fixed"),
    ],
)
def test_bad_parameter_of_the_test_deformation_is_refused(parameters, message):
    with pytest.raises(InputError, match=message):
        DeformationFibres(bar("hexahedron")[1], **parameters)
