import h5py
import numpy as np
import pytest

import risorius
from risorius import storage
from risorius.errors import Error, FileFormatError, InputError


@pytest.fixture
def path(synthetic_model, tmp_path):
    file = tmp_path / "model.h5"
    synthetic_model.save(file)
    return file


def test_a_model_comes_back_as_it_was(synthetic_model, path):
    loaded = risorius.load(path)
    weights = {"AU12_L": 0.7, "AU12_R": 0.2, "jaw_open": 0.4}
    ours, theirs = (risorius.Engine(m).evaluate(weights) for m in (synthetic_model, loaded))
    np.testing.assert_array_equal(ours.vertices, theirs.vertices)
    assert loaded.points == synthetic_model.points
    assert loaded.provenance == synthetic_model.provenance


def test_truncated_file_is_refused(path):
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    with pytest.raises(FileFormatError, match=r"model\.h5.*truncated or foreign"):
        risorius.load(path)


def test_damaged_content_is_refused(path):
    with h5py.File(path, "r+") as file:
        file["rest_vertices"][3, 1] += 1e-4
    with pytest.raises(FileFormatError, match="checksum differs"):
        risorius.load(path)


@pytest.mark.parametrize(
    ("attribute", "value", "message"),
    [
        ("schema", "somebody-else", "holds somebody-else, expected risorius-model"),
        ("schema_version", 99, "schema version 99, this release reads 10"),
        ("units", "mm", "units 'mm', expected 'SI'"),
    ],
)
def test_foreign_files_are_refused_by_what_they_are(path, attribute, value, message):
    with h5py.File(path, "r+") as file:
        file.attrs[attribute] = value
    with pytest.raises(FileFormatError, match=message):
        risorius.load(path)


def test_missing_file_says_how_to_make_one(tmp_path):
    with pytest.raises(InputError, match="no such file; `risorius train SOURCE -o none"):
        risorius.load(tmp_path / "none.h5")


def test_a_failed_write_leaves_the_old_file_and_no_debris(path, tmp_path):
    before = path.read_bytes()
    with pytest.raises(RuntimeError), storage.writing(path, "risorius-model", 1) as file:
        file["half"] = 1
        raise RuntimeError
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_writing_into_a_missing_folder_names_it(synthetic_model, tmp_path):
    with pytest.raises(Error, match=r"the folder .*nowhere does not exist"):
        synthetic_model.save(tmp_path / "nowhere" / "model.h5")
