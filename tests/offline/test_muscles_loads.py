"""Loads: active stress (7.2), force density (7.3) and the insertion cone (Figure 7.6, Table 7.3)."""

import math

import numpy as np
import pytest

from risorius.errors import InputError
from risorius.facs import ACTION_UNITS
from risorius.mechanics.material import Yeoh
from risorius_offline.discretisation import Discretisation
from risorius_offline.elements import ELEMENTS
from risorius_offline.full_model import FullModel
from risorius_offline.muscles.assembly import active_tensors, dead_loads, fibre_points
from risorius_offline.muscles.fibres import InsertionEnd, volume_positions
from risorius_offline.muscles.insertion_cone import TABLE_7_3, InsertionCone
from risorius_offline.muscles.laplace_fibres import LaplaceFibres
from risorius_offline.muscles.loads import ActiveStress, ForceDensity, Insertion
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.polyline_fibres import PolylineFibres
from tests.offline.meshes import box
from tests.offline.models import block_anatomy
from tests.offline.tubes import bar

LENGTH, SECTION = 0.03, 0.008 * 0.006


@pytest.mark.parametrize("cell_type", sorted(ELEMENTS))
def test_force_density_of_a_straight_bar_sums_to_magnitude_times_volume(cell_type):
    """And its moment about the origin to that of the bar's middle, on a distorted mesh."""
    discretisation, region = bar(cell_type)
    (forces,) = dead_loads(discretisation, [Muscle("bar", LaplaceFibres(region), ForceDensity(2e6))]).T
    forces = forces.reshape(-1, 3)
    total = 2e6 * SECTION * LENGTH
    np.testing.assert_allclose(forces.sum(axis=0), [-total, 0.0, 0.0], atol=1e-12 * total)
    assert (forces[:, 0] * discretisation.points[:, 0]).sum() == pytest.approx(-0.5 * total * LENGTH, rel=1e-12)


@pytest.mark.parametrize("cell_type", sorted(ELEMENTS))
def test_active_stress_of_a_straight_bar_pulls_its_ends_together_with_stress_times_section(cell_type):
    discretisation, region = bar(cell_type)
    muscle = Muscle("bar", LaplaceFibres(region), ActiveStress(20e3))
    anatomy = block_anatomy(discretisation.points, discretisation.volumes[0].cells, Yeoh(2500.0, 0.0, 250e3),
                            muscles=(muscle,))  # fmt: skip
    model = FullModel(anatomy, solver="superlu")
    model.set_parameters(np.array([1.0]))
    _, _, gradient = model.forces(np.zeros_like(discretisation.points))
    pull = 20e3 * SECTION
    for area, sign in ((region.origin, 1.0), (region.insertion, -1.0)):
        np.testing.assert_allclose(-gradient[area].sum(axis=0), [sign * pull, 0.0, 0.0], atol=1e-12 * pull)
    inner = np.setdiff1d(np.arange(len(gradient)), np.concatenate([region.origin, region.insertion]))
    np.testing.assert_allclose(gradient[inner], 0.0, atol=1e-12 * pull)


def test_force_density_of_twice_the_stress_by_the_length_does_the_work_of_the_stress_on_a_bar():
    """In a uniform stretch, u = x: lambda A L^2 / 2 against T A L. By Betti's theorem both shorten a bar by T L / E."""
    discretisation, region = bar("hexahedron")
    stress, length = 20e3, LENGTH
    density = Muscle("density", LaplaceFibres(region), ForceDensity(2.0 * stress / length))
    active = Muscle("stress", LaplaceFibres(region), ActiveStress(stress))
    x = discretisation.points[:, 0]
    loads = dead_loads(discretisation, [density, active])
    fibres = fibre_points(discretisation, [density, active])
    tensors = active_tensors(discretisation, fibres, 2).toarray().reshape(-1, 6, 2)
    volumes = discretisation.volumes[0].weights.ravel()
    assert not loads[:, 1].any()
    assert not tensors[:, :, 0].any()
    assert loads[::3, 0] @ x == pytest.approx(-volumes @ tensors[:, 0, 1], rel=1e-12)


def test_fibre_points_are_the_active_tensors_point_by_point():
    """On two blocks of cells, with two muscles that overlap."""
    points, hexahedra = box("hexahedron", cells=(3, 2, 2))
    shifted, wedge = box("wedge", cells=(3, 2, 2))
    second = type(wedge)("wedge", wedge.connectivity + len(points), wedge.layer)
    both = Discretisation(np.concatenate([points, shifted + np.array([0.02, 0.0, 0.0])]), [hexahedra, second])
    line = np.array([[0.0, 0.01, 0.01], [0.04, 0.012, 0.008]])
    muscles = [
        Muscle("one", PolylineFibres((line,), 0.006), ActiveStress(10e3)),
        Muscle("load", PolylineFibres((line,), 0.006), ForceDensity(1e6)),
        Muscle("two", PolylineFibres((line + np.array([0.0, 0.002, 0.0]),), 0.006), ActiveStress(20e3)),
    ]
    found = fibre_points(both, muscles)
    tensors = active_tensors(both, found, 3).toarray().reshape(-1, 6, 3)
    first, second = (block.weights.shape for block in both.volumes)
    numbers = [listed.element * shape[1] + listed.point for listed, shape in zip(found, (first, second), strict=True)]
    number = np.concatenate([numbers[0], first[0] * first[1] + numbers[1]])
    direction, muscle, stress = (
        np.concatenate([getattr(listed, name) for listed in found]) for name in ("direction", "muscle", "stress")
    )
    expected = np.zeros_like(tensors)
    x, y, z = direction.T
    expected[number, :, muscle] = stress[:, None] * np.column_stack([x * x, y * y, z * z, x * y, y * z, z * x])
    np.testing.assert_array_equal(tensors, expected)
    assert (np.diff(number) >= 0).all()
    assert all(len(listed.element) for listed in found)
    assert set(muscle) == {0, 2}


def tissue():
    points, cells = box("hexahedron", cells=(30, 30, 30), size=(0.03, 0.03, 0.03))
    return Discretisation(points, [cells])


END = InsertionEnd(np.array([0.005, 0.015, 0.015]), np.array([1.0, 0.0, 0.0]), 0.004)


def test_insertion_cone_is_a_cone_cut_off_at_the_muscle_and_pulls_to_its_apex():
    """Volume pi / (3 tan(alpha / 2)) (R^3 - r^3). The cone, 15 mm long, ends between two layers of points."""
    discretisation = tissue()
    slope = 0.004 / 0.015
    field = InsertionCone(0.008, 2.0 * math.atan(slope)).field(discretisation, END)
    volume = discretisation.volumes[0].weights.ravel()[field.points].sum()
    assert volume == pytest.approx(math.pi / (3.0 * slope) * (0.008**3 - 0.004**3), rel=2e-3)
    positions = volume_positions(discretisation)[field.points]
    assert positions[:, 0].min() >= 0.005
    assert positions[:, 0].max() <= 0.005 + 0.004 / slope
    towards = np.array([0.005 - 0.004 / slope, 0.015, 0.015]) - positions
    np.testing.assert_allclose(field.directions, towards / np.linalg.norm(towards, axis=1, keepdims=True), atol=1e-12)
    assert -field.directions[:, 0].max() >= math.cos(math.atan(slope))


def test_insertion_has_its_own_magnitude_and_takes_the_tissue_that_the_muscle_shares_with_it():
    discretisation = tissue()
    line = np.array([[0.0, 0.015, 0.015], [0.005, 0.015, 0.015]])
    fibres, cone = PolylineFibres((line,), 0.004), InsertionCone(0.008, math.radians(30.0))
    load = ForceDensity(1e5, Insertion(cone, 4e5))
    forces = dead_loads(discretisation, [Muscle("pull", fibres, load)]).reshape(-1, 3)
    weights = discretisation.volumes[0].weights.ravel()
    muscle, area = fibres.field(discretisation), cone.field(discretisation, END)
    alone = ~np.isin(muscle.points, area.points)
    assert 0 < alone.sum() < len(alone)
    expected = 1e5 * weights[muscle.points[alone]] @ muscle.directions[alone]
    expected = expected + 4e5 * weights[area.points] @ area.directions
    np.testing.assert_allclose(forces.sum(axis=0), expected, atol=1e-12 * np.abs(expected).max())


def test_table_7_3_has_the_seven_muscles_by_the_names_of_the_action_units():
    assert len(TABLE_7_3) == 7
    driven = {muscle for unit in ACTION_UNITS.values() for muscle in unit.muscles}
    assert set(TABLE_7_3) <= driven
    risorius = TABLE_7_3["risorius"]
    assert (risorius.radius, math.degrees(risorius.apex_angle)) == pytest.approx((0.005, 25.0))


def test_bad_cones_are_refused_with_the_remedy():
    with pytest.raises(
        InputError, match=r"radius 0.008 m, apex angle 180 degrees; give a positive radius and an angle"
    ):
        InsertionCone(0.008, math.pi)
    with pytest.raises(
        InputError, match=r"ends with a radius of 4 mm, its insertion cone with 4 mm; give a wider cone"
    ):
        InsertionCone(0.004, 0.5).field(tissue(), END)
    outwards = InsertionEnd(np.array([0.03, 0.015, 0.015]), np.array([1.0, 0.0, 0.0]), 0.004)
    with pytest.raises(InputError, match=r"no tissue in its insertion cone; check where its fibres end"):
        InsertionCone(0.008, 0.5).field(tissue(), outwards)


def test_a_muscle_without_tissue_is_named():
    away = PolylineFibres((np.array([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]),), 0.006)
    for function, load in ((fibre_points, ActiveStress(1e5)), (dead_loads, ForceDensity(1e6))):
        with pytest.raises(InputError, match=r"muscle 'lost': no tissue within its radius of 6 mm"):
            function(tissue(), [Muscle("lost", away, load)])
