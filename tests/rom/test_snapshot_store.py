"""The snapshot file: what is recorded comes back, and what is not a whole snapshot file is refused and left alone."""

import h5py
import numpy as np
import pytest

from risorius.errors import FileFormatError, InputError
from risorius.jaw import JawMotion
from risorius.journalled_file import journal_of
from risorius.poses import Poses
from risorius.snapshot_file import SOLVED, Face, SnapshotSet, stored_settings
from risorius.snapshot_store import Samples, Solved, create, opened
from risorius.surface import CarriedSurface

NODES = 40


@pytest.fixture
def face():
    rng = np.random.default_rng(0)
    points = rng.normal(size=(NODES, 3))
    return Face(
        name="made up",
        muscles=("zygomaticus_major_L", "zygomaticus_major_R"),
        poses=Poses(JawMotion((0.0, -0.02, -0.06), 0.45, 0.008, 0.005, 0.008)),
        points=points,
        surface=CarriedSurface.of_nodes(points, rng.integers(0, NODES, (10, 3))),
        companions={},
        nodal_volumes=rng.uniform(1.0, 2.0, NODES),
        lift_fields=rng.normal(size=(4, NODES, 3)),
        body=None,
        contact=None,
    )


def samples(count, seed=0):
    rng = np.random.default_rng(seed)
    return Samples(rng.uniform(size=(count, 5)), ["ordinary"] * count, np.arange(count) == count - 1, np.arange(count))


def fields(number):
    """Displacement and its derivatives of a made-up solution."""
    rng = np.random.default_rng(number)
    each = {"displacements": (NODES, 3), "derivatives": (5, NODES, 3), "by_gravity": (3, NODES, 3)}
    return {name: rng.normal(size=shape).astype(np.float32) for name, shape in each.items()}


def solved(number):
    slopes = fields(number)
    displacement = slopes.pop("displacements")
    return Solved.of(displacement, slopes, {"smallest_jacobian": 0.5, "seconds": 2.0, "iterations": 7})


@pytest.fixture
def path(face, tmp_path):
    """A file of six samples: the second is given up, the fifth waits, the last is held out."""
    path = tmp_path / "s.h5"
    create(path, face, {"seed": 3}, {"source": "made up"}, derivatives=True)
    with opened(path) as store:
        store.add(samples(6))
        for row in (0, 2, 3, 5):
            store.record(row, solved(row))
        store.give_up(1, "no equilibrium", {"attempts": 3})
    return path


def test_what_was_recorded_comes_back(face, path):
    found = SnapshotSet.load(path)
    np.testing.assert_array_equal(found.parameters, samples(6).parameters[[0, 2, 3, 5]])
    for position, row in enumerate((0, 2, 3, 5)):
        np.testing.assert_array_equal(found.displacements[position], solved(row).displacement)
        np.testing.assert_array_equal(found.derivatives[position], fields(row)["derivatives"])
        np.testing.assert_array_equal(found.by_gravity[position], fields(row)["by_gravity"])
    assert found.displacements.shape == (4, NODES, 3)
    assert found.held_out.tolist() == [False, False, False, True]
    assert found.kinds == ("ordinary",) * 4
    assert found.failures == ("no equilibrium",)
    assert found.smallest_jacobians.tolist() == [0.5] * 4
    assert found.poses == face.poses
    assert stored_settings(path) == {"seed": 3}
    np.testing.assert_array_equal(found.lift_fields, face.lift_fields)


def test_rows_are_read_by_slices_numbers_and_flags(path):
    rows = SnapshotSet.load(path).displacements
    everything = np.stack([solved(row).displacement for row in (0, 2, 3, 5)])
    for index in (slice(1, 3), [2, 0], np.array([True, False, False, True]), -1):
        np.testing.assert_array_equal(rows[index], everything[index])


def test_a_run_finds_what_waits_and_goes_on(path):
    with opened(path) as store:
        assert np.flatnonzero(store.states == SOLVED).tolist() == [0, 2, 3, 5]
        np.testing.assert_array_equal(store.displacement(2), solved(2).displacement)
        store.record(4, solved(4))
        store.add(samples(2, seed=1))
    assert len(SnapshotSet.load(path).parameters) == 5
    with opened(path) as store:
        assert len(store.parameters) == 8


def test_a_file_without_derivatives_says_so(face, tmp_path):
    create(tmp_path / "s.h5", face, {}, {}, derivatives=False)
    with opened(tmp_path / "s.h5") as store:
        store.add(samples(1))
        store.record(0, solved(0))
    assert SnapshotSet.load(tmp_path / "s.h5").derivatives is None


def test_a_reader_sees_each_snapshot_as_soon_as_it_is_recorded(path):
    with opened(path) as store:
        assert len(SnapshotSet.load(path).parameters) == 4
        store.record(4, solved(4))
        found = SnapshotSet.load(path)
        store.add(samples(3, seed=1))
        np.testing.assert_array_equal(found.displacements[3], solved(4).displacement)


def truncate(path):
    path.write_bytes(path.read_bytes()[:-5000])


def write_text(path):
    path.write_text("not a snapshot file\n")


def empty(path):
    path.write_bytes(b"")


def other_schema(path):
    with h5py.File(path, "w") as file:
        file.attrs["schema"] = "risorius-model"


def other_program(path):
    with h5py.File(path, "w") as file:
        file["u"] = np.zeros(3)


def older(path):
    with h5py.File(path, "r+") as file:
        file.attrs["schema_version"] = 3


def damage_face(path):
    with h5py.File(path, "r+") as file:
        file["face/points"][0, 0] += 1e-9


REFUSED = [
    (truncate, "not a readable HDF5 file .*truncated"),
    (write_text, "not a readable HDF5 file .*foreign"),
    (empty, "not a readable HDF5 file"),
    (other_schema, "holds risorius-model, expected risorius-snapshots"),
    (other_program, "holds no Risorius data"),
    (older, "schema version 3, this release reads 6; make the file anew"),
    (damage_face, "the content was damaged"),
]


@pytest.mark.parametrize(("spoil", "message"), REFUSED)
def test_what_is_not_a_whole_snapshot_file_is_refused_and_left_alone(spoil, message, face, path):
    spoil(path)
    before = path.read_bytes()
    with pytest.raises(FileFormatError, match=rf"s\.h5: .*{message}"):
        SnapshotSet.load(path)
    with pytest.raises(FileFormatError, match=rf"s\.h5: .*{message}"), opened(path):
        pass
    with pytest.raises(InputError, match=r"s\.h5: exists already"):
        create(path, face, {}, {}, derivatives=True)
    assert path.read_bytes() == before
    assert not journal_of(path).exists()


def test_a_damaged_snapshot_is_named(path):
    with h5py.File(path, "r") as file:
        chunk = file["samples/displacements"].id.read_direct_chunk((2, 0, 0))[1]
    content = bytearray(path.read_bytes())
    content[content.index(chunk) + 100] ^= 1
    path.write_bytes(content)
    rows = SnapshotSet.load(path).displacements
    rows[0]
    with pytest.raises(FileFormatError, match="displacements of snapshot 2 are damaged"):
        rows[1]


def test_a_file_grows_by_its_snapshots_only(path):
    """Besides 1 080 incompressible floats of each: chunk index, report, journal pages."""
    with opened(path) as store:
        store.add(samples(100, seed=1))
        before = path.stat().st_size
        for row in range(6, 106):
            store.record(row, solved(row))
    assert (path.stat().st_size - before) / 100 < 1.25 * 9 * NODES * 3 * 4
