import numpy as np
import pytest

from risorius.errors import InputError
from risorius.timeline import Timeline

OPENFACE = """frame, timestamp, pose_Rx, pose_Ry, pose_Rz, AU12_r, AU26_r, AU45_r, AU12_c
1, 0.0, 0, 0, 0, 0.0, 0.0, 1.0, 0
2, 0.04, 0.5, 0, 0, 2.5, 1.0, 0.0, 1
3, 0.1, 0, 0, 0, 5.0, 0.0, 0.0, 1
"""


@pytest.fixture
def table(synthetic_model):
    return synthetic_model.inputs


def read(tmp_path, text, table):
    path = tmp_path / "timeline.csv"
    path.write_text(text)
    return Timeline.read(path, table)


def test_a_file_of_openface_becomes_weights_of_the_model_s_inputs(tmp_path, table):
    found = read(tmp_path, OPENFACE, table)
    for name, expected in (("AU12_L", [0.0, 0.5, 1.0]), ("AU12_R", [0.0, 0.5, 1.0]), ("AU26", [0.0, 0.2, 0.0])):
        np.testing.assert_allclose(found.weights[:, table.names.index(name)], expected)
    np.testing.assert_allclose(found.steps, [0.04, 0.04, 0.06])
    expected = [[0, -9.81, 0], [0, -9.81 * np.cos(0.5), 9.81 * np.sin(0.5)], [0, -9.81, 0]]
    np.testing.assert_allclose(found.gravity, expected, atol=1e-12)


def test_columns_may_be_named_as_inputs(tmp_path, table):
    found = read(tmp_path, "AU12_L,jaw_sideways,note\n0.5,-1,a\n0,0,b\n", table)
    assert found.weights[0, table.names.index("AU12_L")] == 0.5
    assert found.weights[0, table.names.index("jaw_sideways")] == -1.0
    assert np.count_nonzero(found.weights) == 2
    np.testing.assert_allclose(found.steps, 1.0 / 60.0)


def test_a_muscle_does_what_the_inputs_ask_of_it(tmp_path, table):
    found = read(tmp_path, "AU12_L,jaw_open\n0.5,0.1\n0,0\n", table)
    np.testing.assert_allclose(
        found.weights_of(("jaw_open", "zygomaticus_major_L", "zygomaticus_major_R"), table),
        [[0.1, 0.5, 0.0], [0.0, 0.0, 0.0]],
    )


def test_expressions_make_a_timeline_that_begins_at_rest(table):
    found = Timeline.of_expressions(table)
    assert not found.weights[0].any()
    assert found.weights[:, table.names.index("AU12_L")].max() == 1.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("AU12\n0.5\nx\n", "line 3: AU12: 'x' is not a number"),
        ("AU12_r\n7\n", "line 2: AU12_r: intensity '7' is not a number in"),
        ("smile\n0.5\n", "line 2: no column is an input of the model among smile"),
        ("AU12\n0.5\n", "1 frames; a timeline has at least two"),
        ("time,AU12\n0,0\n1,0\n1,0\n", "frame 3: time does not go on"),
    ],
)
def test_a_file_that_is_no_timeline_is_refused(tmp_path, table, text, message):
    with pytest.raises(InputError, match=rf"timeline\.csv: {message}"):
        read(tmp_path, text, table)


def test_a_missing_file_is_named(tmp_path, table):
    with pytest.raises(InputError, match=r"none\.csv: no such file"):
        Timeline.read(tmp_path / "none.csv", table)
