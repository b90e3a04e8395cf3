"""Sums of whole numbers: exact, and as near to those of what was rounded as their steps are."""

import numpy as np
import pytest

from risorius.evaluators.whole_weights import WholeWeights
from risorius.paired_sums import LARGEST_INPUT, LARGEST_WEIGHT, MOST_INPUTS, combine, in_numbers, in_pairs
from risorius.vector_sums import whole_blocks


def sums(weights, inputs):
    padded = np.append(inputs, np.zeros(len(inputs) % 2, np.int16))
    out = np.empty(whole_blocks(weights.shape[1]), np.int32)
    combine(in_pairs(weights), padded, out)
    np.testing.assert_array_equal(out[weights.shape[1] :], 0)
    return out[: weights.shape[1]]


@pytest.mark.parametrize("shape", [(1, 1), (2, 64), (7, 65), (60, 256), (571, 240)])
def test_sums_are_exact(shape):
    rng = np.random.default_rng(0)
    weights = rng.integers(-127, 128, shape).astype(np.int8)
    inputs = rng.integers(-8191, 8192, shape[0]).astype(np.int16)
    np.testing.assert_array_equal(sums(weights, inputs), inputs.astype(np.int64) @ weights.astype(np.int64))


@pytest.mark.parametrize("sign", [1, -1])
def test_the_largest_sum_of_the_most_inputs_does_not_overflow(sign):
    weights = np.full((MOST_INPUTS, 1), LARGEST_WEIGHT, np.int8)
    inputs = np.full(MOST_INPUTS, sign * LARGEST_INPUT, np.int16)
    assert sums(weights, inputs)[0] == sign * MOST_INPUTS * LARGEST_WEIGHT * LARGEST_INPUT


def test_more_inputs_are_refused():
    with pytest.raises(ValueError, match="2065 inputs"):
        in_pairs(np.zeros((MOST_INPUTS + 1, 1), np.int8))


@pytest.mark.parametrize("size", [1e-25, 1.0, 1e30])
def test_numbers_are_next_to_values_whatever_their_size(size):
    values = (size * np.random.default_rng(0).normal(size=101)).astype(np.float32)
    numbers = np.empty(102, np.int16)
    step = in_numbers(values, numbers)
    assert np.abs(numbers).max() == LARGEST_INPUT
    assert numbers[-1] == 0
    assert np.abs(numbers[:-1] * np.float64(step) - values).max() <= 0.5001 * step


@pytest.mark.parametrize("value", [0.0, -0.0, 1e-45, 1e-38])
def test_of_next_to_nothing_all_numbers_are_0(value):
    numbers = np.ones(4, np.int16)
    assert in_numbers(np.array([value, 0.0, -value], np.float32), numbers) <= value / LARGEST_INPUT
    np.testing.assert_array_equal(numbers, 0)


def test_weights_are_next_to_values_and_those_of_a_part_are_the_same():
    rng = np.random.default_rng(0)
    values = (rng.normal(size=(50, 30)) * 10.0 ** rng.uniform(-6, 2, 30)).astype(np.float32)
    values[:, 4] = 0.0
    weights = WholeWeights.of(values)
    assert (np.abs(weights.values - values) <= 0.5001 * np.abs(values).max(axis=0) / LARGEST_WEIGHT).all()
    rows, columns = np.array([3, 7, 20]), np.array([4, 11])
    part = weights.rows(rows).columns(columns)
    np.testing.assert_array_equal(part.values, weights.values[np.ix_(rows, columns)])
