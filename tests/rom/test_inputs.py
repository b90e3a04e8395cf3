import numpy as np
import pytest

from risorius.errors import InputError
from risorius.inputs import InputTable
from risorius.jaw import JawMotion

MUSCLES = ("zygomaticus_major_L", "zygomaticus_major_R", "orbicularis_oris_peripheralis", "axial")


@pytest.fixture
def table():
    return InputTable(MUSCLES, JawMotion.inputs)


def test_inputs_are_sided_action_units_then_jaw_then_muscles_without_an_action_unit(table):
    assert table.names[:3] == ("AU8", "AU12_L", "AU12_R")
    assert table.names[-4:] == ("jaw_open", "jaw_forward", "jaw_sideways", "axial")
    assert "AU18" in table.names  # a muscle on the midline: the substitute for the missing incisivi


def test_a_name_without_a_side_moves_both_sides_and_a_sided_one_only_its_own(table):
    both = table.to_parameters(table.weights({"AU12": 0.8}))
    left = table.to_parameters(table.weights({"AU12_L": 0.8}))
    np.testing.assert_array_equal(both[:2], [0.8, 0.8])
    np.testing.assert_array_equal(left[:2], [0.8, 0.0])


def test_several_action_units_on_one_muscle_saturate(table):
    parameters = table.to_parameters(table.weights({"AU18": 1.0, "AU22": 1.0}))
    assert parameters[2] == 1.0


def test_jaw_drop_is_half_of_the_full_opening(table):
    assert table.to_parameters(table.weights({"AU26": 1.0}))[4] == 0.5
    assert table.to_parameters(table.weights({"AU27": 1.0}))[4] == 1.0


@pytest.mark.parametrize(
    ("weights", "message"),
    [
        ({"AU12": 1.5}, "AU12: weight 1.5 is out of range; give a number in \\[0, 1\\]"),
        ({"AU12": float("nan")}, "AU12: weight nan is out of range"),
        ({"jaw_forward": -1.2}, "give a number in \\[-1, 1\\]"),
        ({"AU12": "much"}, "AU12: weight 'much' is not a number"),
        ({"AU1": 0.5}, "AU1.* needs frontalis_medialis, which this model lacks; it understands: AU8, AU12"),
        ({"smile": 0.5}, "'smile' is not known to this model"),
    ],
)
def test_bad_weights_are_refused_with_name_value_and_remedy(table, weights, message):
    with pytest.raises(InputError, match=message):
        table.weights(weights)


def test_array_of_wrong_length_or_with_a_bad_entry_is_refused(table):
    with pytest.raises(InputError, match=r"shape \(3,\) given"):
        table.checked(np.zeros(3))
    weights = np.zeros(len(table.names))
    weights[table.names.index("AU12_R")] = np.inf
    with pytest.raises(InputError, match="AU12_R: weight inf"):
        table.checked(weights)


def test_muscles_are_found_with_and_without_their_side(table):
    np.testing.assert_array_equal(table.activations({"zygomaticus_major": 0.3})[:2], [0.3, 0.3])
    with pytest.raises(InputError, match="muscle 'risorius' is not in this model; it has: zygomaticus_major_L"):
        table.activations({"risorius": 1.0})
