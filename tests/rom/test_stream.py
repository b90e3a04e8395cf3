import numpy as np
import pytest

from risorius.inputs import InputTable
from risorius.jaw import JawMotion
from risorius.stream import InputGate


def test_garbage_on_a_stream_is_left_out_clamped_and_counted():
    table = InputTable(("zygomaticus_major_L", "zygomaticus_major_R"), JawMotion.inputs)
    gate = InputGate(table)
    weights = gate.weights(
        [("AU12_L", 0.5), ("AU12_R", 7.0), ("jaw_forward", -3.0), ("jaw_open", float("nan")), ("AU99", 1.0)]
    )
    found = dict(zip(table.names, weights, strict=True))
    assert found["AU12_L"] == 0.5
    assert found["AU12_R"] == 1.0
    assert found["jaw_forward"] == -1.0
    assert found["jaw_open"] == 0.0
    assert gate.counts == {"clamped": 2, "not_finite": 1, "unknown": 1}
    assert gate.unknown_names == {"AU99"}
    np.testing.assert_array_equal(table.checked(weights), weights)


def test_values_change_only_what_they_name_when_a_base_is_given():
    table = InputTable(("zygomaticus_major_L", "zygomaticus_major_R"))
    base = np.array([0.2, 0.3])
    np.testing.assert_array_equal(InputGate(table).weights([("AU12_R", 0.9)], base), [0.2, 0.9])
    np.testing.assert_array_equal(base, [0.2, 0.3])


@pytest.mark.parametrize("value", [None, "much", [1.0], {}, 10**400, complex(1.0, 1.0), float("-inf")])
def test_what_is_no_number_is_counted_and_left_out(value):
    gate = InputGate(InputTable(("zygomaticus_major_L",)))
    assert not gate.weights([("AU12_L", value)]).any()
    assert gate.counts == {"not_finite": 1}


def test_messages_of_which_names_and_values_do_not_match_are_dropped_and_counted():
    gate = InputGate(InputTable(("zygomaticus_major_L",)))
    assert gate.message(["AU12_L"], [0.5, 0.5]) is None
    assert gate.message(["AU12_L"], [0.5]) == [0.5]
    assert gate.message([], []) == [0.0]
    assert gate.counts["mismatched"] == 1


def test_names_that_are_long_many_or_no_text_do_not_fill_the_memory():
    gate = InputGate(InputTable(("zygomaticus_major_L",)))
    gate.weights([(f"{number}" + "x" * 10_000, 1.0) for number in range(1000)] + [(None, 1.0), ([], 1.0)])
    assert gate.counts["unknown"] == 1002
    assert sum(map(len, gate.unknown_names)) < 10_000
