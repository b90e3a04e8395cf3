"""The table of action units against the seed's Table 7.2, and what drives a head with all its muscles."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.full_head import HEAD

from risorius.errors import InputError
from risorius.facs import ACTION_UNITS
from risorius.inputs import InputTable
from risorius.jaw import JawMotion

# Numbers and names as Table 7.2 of the seed prints them, its "Tightner" mended.
TABLE_7_2 = {
    1: "Inner Brow Raiser",
    2: "Outer Brow Raiser",
    4: "Brow Lowerer",
    5: "Upper Lid Raiser",
    6: "Cheek Raiser",
    7: "Lid Tightener",
    8: "Lips Toward Each Other",
    9: "Nose Wrinkler",
    10: "Upper Lip Raiser",
    11: "Nasolabial Furrow Deepener",
    12: "Lip Corner Puller",
    13: "Cheek puffer",
    14: "Dimpler",
    15: "Lip Corner Depressor",
    16: "Lower Lip Depressor",
    17: "Chin Raiser",
    18: "Lip Puckerer",
    20: "Lip Stretcher",
    22: "Lip Funneler",
    23: "Lip Tightener",
    24: "Lip Pressor",
    25: "Lips Part",
    26: "Jaw Drop",
    27: "Mouth Stretch",
    28: "Lip suck",
    38: "Nostril Dilator",
    39: "Nostril Compressor",
    41: "Lid Droop",
    42: "Slit",
    43: "Eyes Closed",
    44: "Squint",
    45: "Blink",
    46: "Wink",
}
OURS = {21}  # of FACS, not in Table 7.2


def driven(table: InputTable, name: str) -> dict[str, float]:
    """Parameters that are not zero with one input at weight 1."""
    parameters = table.to_parameters(table.weights({name: 1.0}))
    return {table.parameters[i]: float(parameters[i]) for i in np.flatnonzero(parameters)}


def test_every_row_of_table_7_2_is_there_under_its_name():
    ours = {unit.number: unit.name.lower() for unit in ACTION_UNITS.values() if unit.number not in OURS}
    assert ours == {number: name.lower() for number, name in TABLE_7_2.items()}
    assert len(ours) == 33


@pytest.mark.parametrize("name", ACTION_UNITS)
def test_every_unit_acts_on_a_head_with_all_muscles_and_poses(name):
    unit = ACTION_UNITS[name]
    assert {re.sub("_[LR]$", "", parameter) for parameter in driven(HEAD, name)} == {
        *unit.muscles,
        *unit.poses,
        *unit.helpers,
    }


def test_every_muscle_and_every_pose_of_the_head_is_driven_by_a_unit_or_an_input_of_its_own():
    by_units = {parameter for name in ACTION_UNITS for parameter in driven(HEAD, name)}
    assert set(HEAD.parameters) - by_units == {"jaw_forward", "jaw_sideways"}
    assert {"jaw_forward", "jaw_sideways"} <= set(HEAD.names)
    assert set(HEAD.muscles).isdisjoint(HEAD.names)


@pytest.mark.parametrize("name", [name for name in ACTION_UNITS if name not in ("AU26", "AU27")])
def test_sides_are_mirror_images_and_both_together_are_the_unit(name):
    left, right = driven(HEAD, f"{name}_L"), driven(HEAD, f"{name}_R")
    assert {re.sub("_L$", "_R", parameter): share for parameter, share in left.items()} == right
    assert driven(HEAD, name) == left | right
    assert not left.keys() & right.keys()


def test_jaw_units_have_no_sides():
    assert {"AU26", "AU27"} <= set(HEAD.names)
    assert {"AU26_L", "AU27_R"}.isdisjoint(HEAD.aliases)


def test_jaw_drop_and_mouth_stretch_part_the_incisors_as_far_as_people_do():
    """The condyles slide by 8 mm while the jaw turns so far that full opening parts the incisors by 45 mm."""
    incisor = np.array([[0.0, -0.095, 0.0]])

    def parting(opening: float, angle: float) -> float:
        jaw = JawMotion((0.0, -0.03, -0.09), angle, 0.008, 0.005, 0.008)
        return float(
            np.linalg.norm(np.tensordot(jaw.lift_coordinates((opening, 0.0, 0.0)), jaw.unit_motions(incisor), axes=1))
        )

    angle = brentq(lambda angle: parting(1.0, angle) - 0.045, 0.1, 1.2)
    assert parting(driven(HEAD, "AU26")["jaw_open"], angle) >= 0.020
    assert 0.040 <= parting(driven(HEAD, "AU27")["jaw_open"], angle) <= 0.050


def test_lid_units_go_up_or_down_as_their_names_say_and_only_three_close_the_eye():
    lid = {name: driven(HEAD, name).get("upper_lid_L", 0.0) for name in ACTION_UNITS}
    assert [name for name, weight in lid.items() if weight < 0.0] == ["AU5"]
    assert [name for name, weight in lid.items() if weight == 1.0] == ["AU43", "AU45", "AU46"]
    assert 0.0 < lid["AU7"] < lid["AU41"] < lid["AU44"] < lid["AU42"] < 1.0


def test_lips_of_an_undivided_orbicularis_oris_get_the_same_shares():
    published = InputTable(
        tuple(
            f"{muscle}_{side}"
            for muscle in ("orbicularis_oris_marginalis", "orbicularis_oris_peripheralis", "buccinator")
            for side in "LR"
        )
    )
    for name in ("AU8", "AU22", "AU23", "AU24", "AU28"):
        divided = {re.sub("_(superior|inferior)", "", key): share for key, share in driven(HEAD, name).items()}
        assert driven(published, name) == divided


def test_a_face_without_lid_poses_raises_the_lid_by_its_muscle():
    table = InputTable(("levator_palpebrae_superioris_L", "levator_palpebrae_superioris_R"))
    assert driven(table, "AU5_R") == {"levator_palpebrae_superioris_R": 1.0}
    with pytest.raises(InputError, match=r"AU43.* needs upper_lid, which this model lacks"):
        table.weights({"AU43": 1.0})


def test_opposite_lid_units_add_up():
    parameters = dict(zip(HEAD.parameters, HEAD.to_parameters(HEAD.weights({"AU5": 1.0, "AU43": 0.5})), strict=True))
    assert parameters["upper_lid_L"] == pytest.approx(0.2)


def test_the_page_of_units_says_what_the_code_does():
    page = (Path(__file__).parents[2] / "docs" / "facs.md").read_text()
    rows = re.findall(r"^\| (\d+) ([^|]+?) \|[^|]*\| ([^|]+?) \|", page, re.MULTILINE)
    written = {int(number): (name, drive) for number, name, drive in rows}
    for unit in ACTION_UNITS.values():
        shares = {**unit.muscles, **unit.poses, **unit.helpers}
        drive = ", ".join(f"{name} {share:g}" for name, share in shares.items())
        drive = re.sub(r"(\w+)_superior (\S+), \1_inferior \2", r"\1 \2", drive)
        assert written[unit.number] == (unit.name, drive.replace("_", " "))
