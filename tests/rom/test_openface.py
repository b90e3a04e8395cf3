"""Rows of OpenFace's CSV as action-unit weights."""

import csv
import io

import numpy as np
import pytest

from risorius.errors import InputError
from risorius.facs import ACTION_UNITS
from risorius.intensities import LETTER_WEIGHTS
from risorius.openface import action_units, gravity

# Units whose intensity OpenFace gives, after its wiki page on action units; AU28 it gives as a presence only.
UNITS = (1, 2, 4, 5, 6, 7, 9, 10, 12, 14, 15, 17, 20, 23, 25, 26, 45)
HEADER = ["frame", "face_id", "timestamp", "confidence", "success", "gaze_0_x"]
HEADER += [f"AU{unit:02d}_r" for unit in UNITS] + [f"AU{unit:02d}_c" for unit in (*UNITS, 28)]


def test_every_intensity_becomes_a_known_unit_and_nothing_else_does():
    row = dict.fromkeys(HEADER, 1.0)
    assert list(action_units(row)) == [f"AU{unit}" for unit in UNITS]
    assert set(action_units(row)) <= set(ACTION_UNITS)


def test_whole_intensities_are_the_letters_of_facs():
    for intensity, weight in enumerate(LETTER_WEIGHTS.values(), start=1):
        assert action_units({"AU12_r": intensity}) == {"AU12": pytest.approx(weight)}
    assert action_units({"AU12_r": 0.0, "AU01_r": 2.5}) == {"AU12": 0.0, "AU1": 0.5}


@pytest.mark.parametrize("comma", [",", ", "])  # OpenFace 2.2 and before
def test_a_row_of_the_file_is_taken_as_it_is_read(comma):
    text = comma.join(HEADER) + "\n" + comma.join(["1", *["0.5"] * (len(HEADER) - 1)])
    (row,) = csv.DictReader(io.StringIO(text))
    assert action_units(row) == {f"AU{unit}": pytest.approx(0.1) for unit in UNITS}


@pytest.mark.parametrize("value", ["", "-nan", float("nan"), 5.01, -0.1])
def test_what_is_no_intensity_is_refused_with_its_column(value):
    with pytest.raises(InputError, match=r"AU06_r: intensity .* is not a number in \[0, 5\]"):
        action_units({"AU06_r": value})


def test_a_row_without_action_units_says_what_to_do():
    with pytest.raises(InputError, match="no column like AU01_r among frame, gaze_0_x; run OpenFace with -aus"):
        action_units({"frame": 1, "gaze_0_x": 0.1})


@pytest.mark.parametrize(
    ("angles", "expected"),
    [
        ((0.0, 0.0, 0.0), (0.0, -9.81, 0.0)),
        ((0.0, 0.5, 0.0), (0.0, -9.81, 0.0)),  # looking aside changes nothing
        ((np.pi / 2, 0.0, 0.0), (0.0, 0.0, 9.81)),  # looking down: weight pulls the face out
        ((0.0, 0.0, np.pi / 2), (9.81, 0.0, 0.0)),  # lying on the left side
    ],
)
def test_gravity_follows_the_pose_of_the_head(angles, expected):
    row = dict(zip(("pose_Rx", "pose_Ry", "pose_Rz"), map(str, angles), strict=True))
    np.testing.assert_allclose(gravity(row), expected, atol=1e-12)


def test_gravity_of_a_pose_about_all_axes():
    a, b, c = 0.3, 0.4, -0.2
    about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    about_y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    about_z = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    down = (about_x @ about_y @ about_z).T @ [0.0, 9.81, 0.0]
    found = gravity({"pose_Rx": a, "pose_Ry": b, "pose_Rz": c})
    np.testing.assert_allclose(found, [down[0], -down[1], -down[2]], atol=1e-12)


def test_a_pose_that_is_no_angle_is_refused():
    with pytest.raises(InputError, match="pose_Ry: 'x' is not an angle"):
        gravity({"pose_Rx": "0", "pose_Ry": "x", "pose_Rz": "0"})
