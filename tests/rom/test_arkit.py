"""ARKit's blend shapes as inputs of the model."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from tests.full_head import HEAD

import risorius
from risorius.arkit import DRIVES, WITHOUT_EFFECT, action_units
from risorius.errors import InputError

# The constants of ARFaceAnchor.BlendShapeLocation, in the order of Apple's page.
PAGE = """
eyeBlinkLeft eyeLookDownLeft eyeLookInLeft eyeLookOutLeft eyeLookUpLeft eyeSquintLeft eyeWideLeft
eyeBlinkRight eyeLookDownRight eyeLookInRight eyeLookOutRight eyeLookUpRight eyeSquintRight eyeWideRight
jawForward jawLeft jawRight jawOpen mouthClose mouthFunnel mouthPucker mouthLeft mouthRight mouthSmileLeft
mouthSmileRight mouthFrownLeft mouthFrownRight mouthDimpleLeft mouthDimpleRight mouthStretchLeft mouthStretchRight
mouthRollLower mouthRollUpper mouthShrugLower mouthShrugUpper mouthPressLeft mouthPressRight mouthLowerDownLeft
mouthLowerDownRight mouthUpperUpLeft mouthUpperUpRight browDownLeft browDownRight browInnerUp browOuterUpLeft
browOuterUpRight cheekPuff cheekSquintLeft cheekSquintRight noseSneerLeft noseSneerRight tongueOut
"""
ARKIT = PAGE.split()


def mirrored(name: str) -> str:
    """The name of the other side's shape or parameter."""
    swap = {"Left": "Right", "Right": "Left", "_L": "_R", "_R": "_L"}
    return re.sub("(Left|Right|_L|_R)$", lambda match: swap[match[1]], name)


def parameters(coefficients: dict[str, float]) -> dict[str, float]:
    found = HEAD.to_parameters(HEAD.weights(action_units(coefficients)))
    return dict(zip(HEAD.parameters, found.tolist(), strict=True))


def test_each_of_the_52_shapes_drives_something_or_is_said_to_have_no_effect():
    assert len(ARKIT) == 52
    assert sorted([*DRIVES, *WITHOUT_EFFECT]) == sorted(ARKIT)


@pytest.mark.parametrize("shape", DRIVES)
def test_every_shape_moves_a_head_with_all_muscles_and_poses(shape):
    assert any(parameters({shape: 1.0}).values())


@pytest.mark.parametrize("shape", DRIVES)
def test_the_shape_of_the_other_side_is_the_mirror_image(shape):
    other = {mirrored(name): value for name, value in parameters({mirrored(shape): 0.7}).items()}
    other["jaw_sideways"] *= -1.0
    assert parameters({shape: 0.7}) == pytest.approx(other)


def test_left_is_the_persons_own_left():
    assert action_units({"mouthSmileLeft": 0.6}) == {"AU12_L": 0.6}
    assert action_units({"jawLeft": 1.0}) == {"jaw_sideways": 1.0}  # x goes to the person's left


def test_shapes_that_share_an_input_add_up_to_full_weight_at_most():
    assert action_units({"mouthStretchLeft": 0.25, "mouthLeft": 0.5}) == {"AU20_L": 0.5, "AU14_L": 0.25}
    assert action_units({"mouthStretchLeft": 1.0, "mouthLeft": 1.0})["AU20_L"] == 1.0
    assert action_units({"jawLeft": 0.75, "jawRight": 0.25}) == {"jaw_sideways": 0.5}


def test_all_shapes_at_once_are_admissible():
    with pytest.warns(UserWarning):
        found = parameters(dict.fromkeys(ARKIT, 1.0))
    assert max(found.values()) == 1.0
    assert found["jaw_sideways"] == 0.0


def test_gaze_and_tongue_are_ignored_and_reported_once_not_every_frame():
    frame = {"jawOpen": 0.5, "eyeLookInLeft": 0.3, "tongueOut": 1.0}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        found = [action_units(frame) for _ in range(60)]
    assert found == [{"jaw_open": 0.5}] * 60
    assert [str(warning.message) for warning in caught] == [
        "ARKit's gaze, tongue and cheekPuff move no tissue of the model: ignored"
    ]


@pytest.mark.parametrize(
    ("coefficients", "message"),
    [
        ({"smile": 0.5}, "'smile' is not a blend shape of ARKit"),
        ({"jawOpen": 1.2}, "jawOpen: coefficient 1.2 is out of range"),
        ({"tongueOut": float("nan")}, "tongueOut: coefficient nan is out of range"),
    ],
)
def test_what_is_not_of_arkit_is_refused(coefficients, message):
    with pytest.raises(InputError, match=message):
        action_units(coefficients)


def test_coefficients_go_straight_into_the_engine(synthetic_model):
    engine = risorius.Engine(synthetic_model)
    ours = engine.evaluate(risorius.arkit.action_units({"mouthSmileLeft": 0.8, "jawOpen": 0.25}))
    np.testing.assert_array_equal(ours.vertices, engine.evaluate({"AU12_L": 0.8, "jaw_open": 0.25}).vertices)


def test_the_page_lists_every_shape_as_the_code_has_it():
    page = (Path(__file__).parents[2] / "docs" / "facs.md").read_text()
    rows = re.findall(r"^\| `([^|]+)` \| ([^|]+?) \|", page, re.MULTILINE)
    written = {shape: drive for shapes, drive in rows for shape in shapes.split("`, `")}
    for shape in ARKIT:
        drive = ", ".join(f"{name} {share:g}" for name, share in DRIVES.get(shape, {}).items()) or "none"
        unsided = re.sub("_[LR] ", " ", drive)
        key = next(key for key in (shape, re.sub("(Left|Right)$", "Left/Right", shape)) if key in written)
        assert written[key] == (drive if key == shape else unsided), shape
