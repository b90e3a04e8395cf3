"""Import of a folder: a made-up face of 8 x 8 x 2 hexahedra in millimetres, with z up and x backwards."""

import json
import re
import shutil
from pathlib import Path

import meshio
import numpy as np
import pytest

from risorius.errors import InputError
from risorius_offline.anatomy import Anatomy, load_source
from risorius_offline.anatomy.frame import parse_frame
from tests.offline.meshes import box_hexahedra

FRAME = "x: anterior(-) to posterior(+), y: lateral, mid-sagittal plane y=0, z: inferior to superior"
SIZE = (20.0, 120.0, 140.0)  # back, right, up


def made_up_face():
    points, cells = box_hexahedra((2, 8, 8), SIZE)
    points -= [0.0, 60.0, 0.0]
    back = np.isclose(points[:, 0], SIZE[0])
    low = points[:, 2] < 60.0
    front = points[:, 0] < 1e-9
    nose = front & (np.abs(points[:, 1]) < 1.0) & np.isclose(points[:, 2], 70.0)
    points[nose, 0] -= 15.0
    flags = {"fixed_to_skull": back & ~low, "fixed_to_jaw": back & low, "free_inner_lip": back & False}
    return meshio.Mesh(points, [("hexahedron", cells)], point_data={k: v.astype(np.uint8) for k, v in flags.items()})


def mandible():
    """Two rami with condyles at the back and top, a body with an incisal edge in front; millimetres."""
    right, left = [[90.0, -45.0, 75.0], [80.0, -45.0, 30.0]], [[90.0, 45.0, 75.0], [80.0, 45.0, 30.0]]
    front = [[5.0, 0.0, 40.0], [5.0, 2.0, 20.0], [8.0, -2.0, 10.0]]
    points = np.array(right + left + front)
    return meshio.Mesh(points, [("triangle", np.array([[0, 1, 4], [2, 3, 4], [1, 3, 5], [4, 5, 6]]))])


def muscle_file(**changes):
    content = {
        "units": "mm",
        "frame": FRAME,
        "muscles": [
            {
                "id": "ZYG",
                "name": "zygomaticus major",
                "fibres_one_side_m": [[[0.010, -0.05, 0.09], [0.008, -0.03, 0.05]]],
                "radius_m": 0.012,
            }
        ],
    }
    return {**content, **changes}


@pytest.fixture
def folder(tmp_path):
    made_up_face().write(tmp_path / "face.vtu")
    mandible().write(tmp_path / "jaw.ply")
    (tmp_path / "muscles.json").write_text(json.dumps(muscle_file()))
    return tmp_path


def rewrite(folder: Path, change):
    mesh = meshio.read(folder / "face.vtu")
    change(mesh)
    mesh.write(folder / "face.vtu")


def test_import_turns_units_and_axes_into_ours(folder):
    anatomy = load_source(str(folder))
    extent = np.ptp(anatomy.points, axis=0)
    np.testing.assert_allclose(extent, [0.120, 0.140, 0.035], atol=1e-6)
    assert [m.name for m in anatomy.muscles] == ["zygomaticus_major_L", "zygomaticus_major_R"]
    left, right = (m.fibres.lines[0] for m in anatomy.muscles)
    assert left[:, 0].min() > 0  # the person's left is +x; the source's y points to the right
    np.testing.assert_array_equal(left * [-1, 1, 1], right)
    assert anatomy.points[anatomy.jaw, 1].max() < anatomy.points[anatomy.skull, 1].min()


def test_skin_is_the_outside_without_the_deep_side(folder):
    anatomy = load_source(str(folder))
    a, b, c = np.moveaxis(anatomy.points[anatomy.skin], 1, 0)
    normal = np.cross(b - a, c - a)
    assert not (anatomy.skull | anatomy.jaw)[anatomy.skin].all(axis=1).any()
    assert normal[:, 2].sum() == pytest.approx(2 * 0.120 * 0.140, rel=1e-6)  # all of the front, facing forwards


def test_jaw_opens_by_45_mm_between_the_incisors(folder):
    anatomy = load_source(str(folder))
    incisor = anatomy.bones["jaw"].points[4:5]
    moved = np.tensordot(
        anatomy.jaw_motion.lift_coordinates((1.0, 0.0, 0.0)), anatomy.jaw_motion.unit_motions(incisor), axes=1
    )[0]
    assert np.linalg.norm(moved) == pytest.approx(0.045, abs=1e-9)
    assert moved[1] < -0.03


def test_anatomy_file_comes_back_as_it_was(folder, tmp_path):
    anatomy = load_source(str(folder))
    anatomy.save(tmp_path / "face.h5")
    loaded = Anatomy.load(tmp_path / "face.h5")
    np.testing.assert_array_equal(loaded.points, anatomy.points)
    np.testing.assert_array_equal(loaded.skin, anatomy.skin)
    assert loaded.materials == anatomy.materials
    assert loaded.jaw_motion == anatomy.jaw_motion
    assert loaded.epidermis == anatomy.epidermis
    np.testing.assert_array_equal(loaded.muscles[1].fibres.lines[0], anatomy.muscles[1].fibres.lines[0])


def drop(name):
    return lambda mesh: mesh.point_data.pop(name)


def invert(mesh):
    mesh.cells[0].data[5] = mesh.cells[0].data[5][[4, 5, 6, 7, 0, 1, 2, 3]]


def stretch(mesh):
    mesh.points *= 1000.0


def number_layers(mesh):
    mesh.cell_data["layer"] = [np.arange(len(mesh.cells[0].data)) % 3]


def spoil(mesh):
    mesh.points[7, 1] = np.nan


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (drop("fixed_to_skull"), r"face.vtu: node flag 'fixed_to_skull' is missing \(point data found: .*add it"),
        (drop("fixed_to_jaw"), r"face.vtu: node flag 'fixed_to_jaw' is missing"),
        (invert, r"face.vtu: 1 hexahedron cell\(s\) are inverted or flat, first cell 5"),
        (stretch, r"face.vtu: the mesh is 1.4e\+05 mm wide, a face is 0.1 to 0.4 m; correct 'units'"),
        (spoil, r"face.vtu: node 7 is not finite"),
        (number_layers, r"face.vtu: cell data 'layer' runs from 0 to 2, muscles.json has 1 material\(s\); number"),
    ],
)
def test_bad_mesh_is_refused_with_file_item_and_remedy(folder, change, message):
    rewrite(folder, change)
    with pytest.raises(InputError, match=message):
        load_source(str(folder))


def far_away():
    return [{"id": "ZYG", "name": "zyg", "fibres_one_side_m": [[[0.01, -0.05, 0.09], [0.01, -0.05, 0.39]]]}]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (muscle_file(units="m"), r"face.vtu: the mesh is 140 m wide, a face is 0.1 to 0.4 m; correct 'units'.*now 'm'"),
        (muscle_file(units="inch"), r"muscles.json: units 'inch' are not known; write one of m, cm, mm"),
        (muscle_file(frame="z is up"), r"muscles.json: frame 'z is up' does not name three axes"),
        (muscle_file(muscles=far_away()), r"muscle 'zyg_L', line 0, point 1 lies \d+ mm outside the mesh"),
        (muscle_file(muscles=[]), r"muscles.json: field muscles: List should have at least 1 item"),
        (
            muscle_file(muscles=[{"id": "A", "name": "a"}]),
            r"muscle 'A': it has no fibres; give exactly one of fibres_one_side_m, fibres_m, ",
        ),
    ],
)
def test_bad_muscle_file_is_refused_with_file_item_and_remedy(folder, content, message):
    (folder / "muscles.json").write_text(json.dumps(content))
    with pytest.raises(InputError, match=message):
        load_source(str(folder))


def test_missing_and_unreadable_files_are_named(folder, tmp_path):
    (folder / "face.vtu").write_text("not a mesh")
    with pytest.raises(InputError, match=r"face.vtu: meshio cannot read it"):
        load_source(str(folder))
    shutil.copy(folder / "face.vtu", folder / "other.vtu")
    with pytest.raises(InputError, match=r"2 volume meshes found \(face.vtu, other.vtu\); put exactly one"):
        load_source(str(folder))
    (folder / "muscles.json").write_text("{")
    (folder / "other.vtu").unlink()
    with pytest.raises(InputError, match="not JSON"):
        load_source(str(folder))
    with pytest.raises(InputError, match="no such file or folder"):
        load_source(str(tmp_path / "nowhere"))


def test_frame_needs_three_right_handed_axes():
    ours = parse_frame("x: right to left, y: inferior to superior, z: posterior to anterior", "m", "f")
    np.testing.assert_array_equal(ours.rotation, np.eye(3))
    with pytest.raises(InputError, match="right-handed"):
        parse_frame("x: left to right, y: inferior to superior, z: posterior to anterior", "m", "f")


def test_published_face_is_imported_whole(published_face):
    assert len(published_face.points) == 8720
    assert {b.cell_type: len(b.connectivity) for b in published_face.cells} == {"hexahedron": 6024, "wedge": 318}
    assert len(published_face.muscles) == 22
    extent = np.ptp(published_face.points, axis=0)
    np.testing.assert_allclose(extent, [0.1687, 0.1733, 0.1564], atol=1e-4)
    nose = published_face.points[published_face.points[:, 2].argmax()]
    assert -0.06 < nose[1] < -0.03  # the tip of the nose lies 30 to 60 mm below the sellion
    assert re.match("zygomaticus", published_face.muscles[18].name)


def test_published_face_has_a_closed_skin_around_its_openings(published_face):
    edges = np.sort(published_face.skin[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, count = np.unique(edges, axis=0, return_counts=True)
    assert count.max() == 2  # a manifold: no edge has three triangles
