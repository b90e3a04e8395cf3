"""Muscles in files: every construction and load comes back from HDF5, and muscles.json understands all of them."""

import json
import math
from dataclasses import asdict

import h5py
import meshio
import numpy as np
import pytest

from risorius.errors import InputError
from risorius_offline.anatomy import Anatomy, load_source
from risorius_offline.anatomy.layers import LAYERS, layer_materials
from risorius_offline.discretisation import Discretisation
from risorius_offline.muscles.deformation_fibres import DeformationFibres
from risorius_offline.muscles.ellipse import Ellipse
from risorius_offline.muscles.insertion_cone import TABLE_7_3, InsertionCone
from risorius_offline.muscles.laplace_fibres import LaplaceFibres
from risorius_offline.muscles.loads import LOADS, ActiveStress, ForceDensity, Insertion
from risorius_offline.muscles.muscle import CONSTRUCTIONS, Muscle
from risorius_offline.muscles.polyline_fibres import PolylineFibres
from risorius_offline.muscles.radial_fibres import RadialFibres
from risorius_offline.muscles.region import Region
from risorius_offline.muscles.ring_fibres import RingFibres
from risorius_offline.muscles.spline_fibres import SplineFibres
from tests.offline.test_import_folder import made_up_face, muscle_file

LINES = (
    np.array([[0.0, 0.0, 0.0], [0.01, 0.0, 0.0]]),
    np.array([[0.0, 0.01, 0.0], [0.01, 0.01, 0.0], [0.02, 0.0, 0.0]]),
)
REGION = Region({"wedge": np.array([3, 5]), "hexahedron": np.array([1])}, np.array([7]), np.array([8, 9]))
ELLIPSE = Ellipse((0.0, 0.1, 0.2), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.02, 0.01))
EVERY_KIND = [
    Muscle("a", PolylineFibres(LINES, 0.006), ActiveStress(90e3)),
    Muscle("b", SplineFibres(LINES, 0.006, 0.003), ForceDensity(1e6)),
    Muscle("c", LaplaceFibres(REGION), ForceDensity(1e6, Insertion(InsertionCone(0.008, 0.5), 4e6))),
    Muscle("d", DeformationFibres(REGION, 0.4, "fixed"), ActiveStress(90e3)),
    Muscle("e", RingFibres(ELLIPSE, 0.004), ActiveStress(90e3)),
    Muscle("f", RadialFibres(ELLIPSE, 0.004), ForceDensity(1e6)),
]


def test_the_cases_below_have_every_construction_and_load():
    assert {muscle.fibres.kind for muscle in EVERY_KIND} == set(CONSTRUCTIONS)
    assert {muscle.load.kind for muscle in EVERY_KIND} == set(LOADS)


@pytest.mark.parametrize("muscle", EVERY_KIND, ids=lambda muscle: f"{muscle.fibres.kind}-{muscle.load.kind}")
def test_muscle_comes_back_from_its_file_as_it_was(muscle):
    with h5py.File("muscle", "w", driver="core", backing_store=False) as file:
        muscle.write(file)
        found = Muscle.read(file)
    assert found.name == muscle.name
    assert found.load == muscle.load
    assert type(found.fibres) is type(muscle.fibres)
    np.testing.assert_equal(asdict(found.fibres), asdict(muscle.fibres))


def test_layers_are_stiff_by_the_ratio_of_muscle_to_skin():
    """Young's modulus is 9 K G / (3 K + G) with the shear modulus G = 2 c10."""
    materials = layer_materials(0.2)
    moduli = [9.0 * m.bulk * 2.0 * m.c10 / (3.0 * m.bulk + 2.0 * m.c10) for m in materials]
    assert len(LAYERS) == 4
    np.testing.assert_allclose(moduli, [40e3, 5e3, 8e3, 6e3])
    with pytest.raises(InputError, match=r"muscle_to_skin = 0; give a positive ratio"):
        layer_materials(0.0)


# The made-up face: x to the back, y to the right, z up; 20 x 120 x 140 mm from (0, -60, 0).
ZYG = {"id": "ZYG", "name": "zygomaticus major"}
LINE = [[[0.010, -0.05, 0.09], [0.009, -0.04, 0.07], [0.008, -0.03, 0.05]]]
CIRCLE = {"centre_m": [0.01, -0.03, 0.09], "normal": [1, 0, 0], "first_axis": [0, 1, 0], "semi_axes_m": [0.02, 0.015]}


def imported(folder, **changes):
    made_up_face().write(folder / "face.vtu")
    (folder / "muscles.json").write_text(json.dumps(muscle_file(**changes)))
    return load_source(str(folder))


def only(**entry):
    return [{**ZYG, "radius_m": 0.008, **entry}]


def test_splines_are_mirrored_with_their_radii(tmp_path):
    left, right = imported(tmp_path, muscles=only(splines_one_side_m=LINE, radius_m=[0.012, 0.008])).muscles
    assert (left.name, right.name) == ("zygomaticus_major_L", "zygomaticus_major_R")
    assert (left.fibres.origin_radius, left.fibres.insertion_radius) == (0.012, 0.008)
    assert left.fibres.lines[0][:, 0].min() > 0  # the source's y points to the right
    np.testing.assert_array_equal(left.fibres.lines[0] * [-1, 1, 1], right.fibres.lines[0])


def test_force_density_takes_its_cone_from_table_7_3_or_from_the_entry(tmp_path):
    force = {"magnitude_n_m3": 1e6, "insertion": {"magnitude_n_m3": 5e6}}
    entry = only(splines_one_side_m=LINE, radius_m=[0.012, 0.004], force_density=force)
    muscle = imported(tmp_path, muscles=entry).muscles[0]
    assert muscle.load == ForceDensity(1e6, Insertion(TABLE_7_3["zygomaticus_major"], 5e6))
    force["insertion"] |= {"apex_angle_deg": 28.0, "radius_m": 0.006}
    muscle = imported(tmp_path, muscles=entry).muscles[0]
    assert muscle.load.insertion.cone == InsertionCone(0.006, math.radians(28.0))


def test_sphincters_turn_into_our_frame_and_onto_both_sides(tmp_path):
    entries = [
        {"id": "OOC", "name": "orbicularis oculi", "ring_one_side": CIRCLE, "radius_m": 0.008},
        {"id": "OOR", "name": "orbicularis oris", "radial": {**CIRCLE, "centre_m": [0.01, 0.0, 0.05]},
         "radius_m": 0.008, "force_density": {"magnitude_n_m3": 1e6}},
    ]  # fmt: skip
    left, right, oris = imported(tmp_path, muscles=entries).muscles
    assert [m.name for m in (left, right, oris)] == ["orbicularis_oculi_L", "orbicularis_oculi_R", "orbicularis_oris"]
    assert left.fibres.ellipse.centre[0] == pytest.approx(0.03)
    assert right.fibres.ellipse.centre[0] == pytest.approx(-0.03)
    np.testing.assert_allclose(np.abs(left.fibres.ellipse.normal), [0.0, 0.0, 1.0])
    assert isinstance(oris.fibres, RadialFibres)


def mark_region(folder, name="ZYG"):
    """A bar of cells from low to high at the person's left."""
    mesh = meshio.read(folder / "face.vtu")
    _, y, z = mesh.points.T
    chosen = (y < 1.0) & (y > -31.0)
    cells = chosen[mesh.cells[0].data].all(axis=1)
    inside = np.zeros(len(mesh.points), dtype=bool)
    inside[mesh.cells[0].data[cells]] = True
    mesh.cell_data[f"muscle_{name}"] = [cells.astype(np.uint8)]
    mesh.point_data[f"origin_{name}"] = (inside & np.isclose(z, z.max())).astype(np.uint8)
    mesh.point_data[f"insertion_{name}"] = (inside & np.isclose(z, 0.0)).astype(np.uint8)
    mesh.write(folder / "face.vtu")


@pytest.mark.parametrize("method", ["laplace", "deformation"])
def test_region_comes_from_the_marks_of_the_mesh(tmp_path, method):
    imported(tmp_path)
    mark_region(tmp_path)
    entry = {**ZYG, "side": "L", "region": {"method": method}}
    (tmp_path / "muscles.json").write_text(json.dumps(muscle_file(muscles=[entry])))
    anatomy = load_source(str(tmp_path))
    (muscle,) = anatomy.muscles
    assert (muscle.name, muscle.fibres.kind) == ("zygomaticus_major_L", method)
    anatomy.save(tmp_path / "face.h5")
    loaded = Anatomy.load(tmp_path / "face.h5")
    field = loaded.muscles[0].fibres.field(Discretisation(loaded.points, loaded.cells))
    assert len(field.points) == 8 * 2 * 2 * 8
    assert field.directions[:, 1].min() > 0.5  # up, from the insertion to the origin


def test_layers_stand_for_the_materials(tmp_path):
    assert imported(tmp_path, layers={"muscle_to_skin": 0.25}).materials == layer_materials(0.25)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"muscles": only(fibres_m=LINE, splines_m=LINE)},
         r"muscle 'ZYG': it has fibres_m and splines_m; give exactly one of fibres_one_side_m, .*, region$"),
        ({"muscles": only(fibres_m=LINE, radius_m=[0.01, 0.02])},
         r"muscle 'ZYG': radius_m: a pair \(0.01, 0.02\) goes with splines only; give one number"),
        ({"muscles": only(fibres_one_side_m=LINE, side="L")},
         r"muscle 'ZYG': side: 'L' contradicts 'fibres_one_side_m', which makes both sides; leave one of them out"),
        ({"muscles": only(fibres_m=LINE, max_stress_pa=1e5, force_density={"magnitude_n_m3": 1e6})},
         r"muscle 'ZYG': it has 'max_stress_pa' and 'force_density'; give one of them"),
        ({"muscles": only(ring=CIRCLE, force_density={"magnitude_n_m3": 1e6})},
         r"muscle 'ZYG': .*a force density along a ring turns the tissue"),
        ({"muscles": [{"id": "M", "name": "mentalis", "fibres_m": LINE,
                       "force_density": {"magnitude_n_m3": 1e6, "insertion": {"magnitude_n_m3": 1e6}}}]},
         r"muscle 'M': insertion: Table 7.3 has no 'mentalis' .*; give 'radius_m' and 'apex_angle_deg'"),
        ({"muscles": only(region={"method": "laplace"})},
         r"face.vtu: cell data 'muscle_ZYG' is missing \(cell data found: none\); add it as 0/1 cell data"),
        ({"muscles": only(region={"method": "flow"})},
         r"muscles.json: field muscles.0.region.method: Input should be 'laplace' or 'deformation' \(found 'flow'\)"),
        ({"muscles": only(ring={**CIRCLE, "semi_axes_m": [0.02, -0.01]})},
         r"muscles.json: field muscles.0.ring.semi_axes_m.1: Input should be greater than 0 \(found -0.01\)"),
        ({"muscles": only(ring={**CIRCLE, "first_axis": [2, 0, 0]})},
         r"muscle 'ZYG': ellipse: normal .* and first axis .* are parallel or zero"),
        ({"muscles": only(ring={**CIRCLE, "centre_m": [0.3, 0.0, 0.05]})},
         r"muscles.json: muscle 'zygomaticus_major': no tissue within its radius of 8 mm; check its coordinates"),
        ({"layers": {"muscle_to_skin": -1}},
         r"muscles.json: field layers.muscle_to_skin: Input should be greater than 0 \(found -1\)"),
        ({"layers": {}, "materials": [{"c10": 1e3, "bulk": 1e5}]},
         r"muscles.json: it has 'materials' and 'layers'; give one of them"),
    ],
)  # fmt: skip
def test_bad_entries_are_refused_with_field_value_and_remedy(tmp_path, changes, message):
    with pytest.raises(InputError, match=message):
        imported(tmp_path, **changes)
