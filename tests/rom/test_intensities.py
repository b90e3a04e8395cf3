"""FACS scores as weights and back."""

import numpy as np
import pytest

from risorius import Engine
from risorius.errors import InputError
from risorius.facs import ACTION_UNITS
from risorius.intensities import LETTER_WEIGHTS, action_units, score


def test_letters_are_five_equal_steps_up_to_full_weight():
    assert "".join(LETTER_WEIGHTS) == "ABCDE"
    np.testing.assert_allclose(list(LETTER_WEIGHTS.values()), np.arange(1, 6) / 5)


def test_a_score_names_each_unit_with_its_letter_or_severe():
    assert action_units("1C+2C+5B+26") == {"AU1": 0.6, "AU2": 0.6, "AU5": 0.4, "AU26": 0.8}


def test_one_sided_scores_keep_the_persons_own_side():
    assert action_units("L12D + R14A") == {"AU12_L": 0.8, "AU14_R": 0.2}


def test_an_empty_score_is_the_neutral_face():
    assert action_units("") == {} == action_units(" ")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("12F", "'12F' is not \\[L|R\\]NUMBER"),
        ("AU12", "'AU12' is not"),
        ("1++2", "'' is not"),
        ("T28", "'T28' is not"),
        ("1C+99", "AU99 is not known"),
        ("12C+12D", "'12D' scores its unit a second time"),
    ],
)
def test_what_is_no_score_is_refused_by_its_part(text, message):
    with pytest.raises(InputError, match=message):
        action_units(text)


@pytest.mark.parametrize("letter", LETTER_WEIGHTS)
def test_scores_come_back_as_they_were(letter):
    for side in ("", "L", "R"):
        text = "+".join(f"{side}{unit.number}{letter}" for unit in ACTION_UNITS.values())
        assert score(action_units(text)) == text


def test_weights_are_scored_at_the_nearest_letter_and_traces_of_a_trace_not_at_all():
    assert score({"AU1": 0.05, "AU2": 0.29, "AU12_L": 0.31, "AU26": 1.0}) == "2A+L12B+26E"


@pytest.mark.parametrize(
    ("weights", "message"),
    [({"jaw_open": 0.5}, "not an action unit"), ({"AU12": 1.2}, "out of range"), ({"AU12": float("nan")}, "out of")],
)
def test_what_has_no_score_is_refused(weights, message):
    with pytest.raises(InputError, match=message):
        score(weights)


def test_the_engine_takes_letters_in_place_of_numbers(synthetic_model):
    engine = Engine(synthetic_model)
    lettered = engine.evaluate({"AU12_L": "C", "AU26": "A"}, muscles={"zygomaticus_major_R": "B"})
    numbered = engine.evaluate({"AU12_L": 0.6, "AU26": 0.2}, muscles={"zygomaticus_major_R": 0.4})
    np.testing.assert_array_equal(lettered.vertices, numbered.vertices)
    scored = engine.evaluate(action_units("L12C+26A"))
    np.testing.assert_array_equal(scored.vertices, engine.evaluate({"AU12_L": "C", "AU26": "A"}).vertices)
