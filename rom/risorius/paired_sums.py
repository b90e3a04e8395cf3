"""Sums of whole numbers times weights of eight bits: what an answer of the network takes its time for.

Two products and their sum are one instruction for sixteen lanes (vpdpwssd; pmaddwd and an addition before AVX-512), and
weights a half of the bytes that sixteen bits take.
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
import numpy.typing as npt
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic

from risorius.vector_lanes import INT, LANES, SHORT, accumulated, data_pointers, shuffle
from risorius.vector_sums import WIDTH, whole_blocks

LARGEST_WEIGHT, LARGEST_INPUT = 127, 8191
MOST_INPUTS = (2**31 - 1) // (LARGEST_WEIGHT * LARGEST_INPUT)  # of a sum: 2 064
LEAST = np.float32(1e-30)  # what is less counts as 0
_INTS, _BOTH = ir.VectorType(INT, LANES), ir.VectorType(INT, 2 * LANES)

Bytes = npt.NDArray[np.int8]


def in_pairs(numbers: Bytes) -> Bytes:
    """Weights (n, m) flat, as `combine` takes them: whole blocks of pairs of rows, filled up with zeros.

    Raises ValueError for more than MOST_INPUTS rows, whose sums may not fit 32 bits.
    """
    count, size = numbers.shape
    if count > MOST_INPUTS:
        raise ValueError(f"{count} inputs: sums of more than {MOST_INPUTS} may not fit 32 bits; give fewer")
    pairs, blocks = -(-count // 2), whole_blocks(size) // WIDTH
    padded = np.zeros((2 * pairs, blocks * WIDTH), np.int8)
    padded[:count, :size] = numbers
    return padded.reshape(pairs, 2, blocks, WIDTH).transpose(2, 0, 3, 1).ravel()


@numba.njit(cache=True)
def in_numbers(values, out):  # type: ignore[no-untyped-def]
    """Write values (n,) as whole numbers of a step, up to LARGEST_INPUT, into out, n or n + 1 long; return the step."""
    bits, largest_bits = values.view(np.int32), np.int32(0)
    for i in range(len(bits)):  # without their sign, floats are in the order of their bits
        largest_bits = max(largest_bits, np.int32(bits[i] & 0x7FFFFFFF))
    largest = np.int32(largest_bits).view(np.float32)
    inverse = np.float32(LARGEST_INPUT) / largest if largest > LEAST else np.float32(0.0)
    out[len(out) - 1] = 0
    for i in range(len(values)):
        out[i] = np.int16(np.rint(values[i] * inverse))
    return largest / np.float32(LARGEST_INPUT)


@numba.njit(cache=True)
def combine(weights, inputs, out):  # type: ignore[no-untyped-def]
    """Write the sums of inputs (n,) int16, n even and at most MOST_INPUTS, times weights into `out` (m,) int32.

    All arrays are contiguous; m is that of whole blocks.
    """
    for block in range(len(out) // WIDTH):
        _combine_block(weights, inputs, out, block, len(inputs) // 2)


@intrinsic
def _combine_block(context, weights, inputs, out, block, pairs):  # type: ignore[no-untyped-def]
    parts = range(0, WIDTH, LANES)

    def generate(target: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        weights, inputs, out = data_pointers(target, builder, signature.args[:3], arguments[:3])
        block, pairs = arguments[3:]
        first = builder.mul(builder.mul(block, pairs), block.type(2 * WIDTH))
        every_pair = builder.bitcast(inputs, INT.as_pointer())

        def added(number: Any, totals: list[Any]) -> list[Any]:
            pair = _pair_in_lanes(builder, every_pair, number)
            start = builder.add(first, builder.mul(number, number.type(2 * WIDTH)))
            places = [builder.add(start, start.type(2 * part)) for part in parts]
            factors = [_load_bytes(builder, weights, place) for place in places]
            products = [builder.mul(factor, pair, flags=("nsw",)) for factor in factors]
            return [builder.add(total, _of_pairs(builder, two)) for total, two in zip(totals, products, strict=True)]

        zeros = [ir.Constant(_INTS, [0] * LANES) for _ in parts]
        for part, total in zip(parts, accumulated(builder, pairs.type(0), pairs, zeros, added), strict=True):
            place = builder.add(builder.mul(block, block.type(WIDTH)), block.type(part))
            builder.store(total, builder.bitcast(builder.gep(out, [place]), _INTS.as_pointer()), align=4)
        return target.get_dummy_value()

    return types.void(weights, inputs, out, types.int64, types.int64), generate


def _pair_in_lanes(builder: Any, pairs: Any, number: Any) -> Any:
    """Both numbers of a pair of 16-bit ones, again and again, with 32 bits."""
    pair = builder.load(builder.gep(pairs, [number]), align=2)
    single = builder.insert_element(ir.Constant(_INTS, ir.Undefined), pair, INT(0))
    lanes = shuffle(builder, single, single, [0] * LANES)
    return builder.sext(builder.bitcast(lanes, ir.VectorType(SHORT, 2 * LANES)), _BOTH)


def _load_bytes(builder: Any, array: Any, place: Any) -> Any:
    """Pairs of 8-bit numbers from a place on, with 32 bits."""
    pointer = builder.bitcast(builder.gep(array, [place]), ir.VectorType(ir.IntType(8), 2 * LANES).as_pointer())
    return builder.sext(builder.load(pointer, align=1), _BOTH)


def _of_pairs(builder: Any, products: Any) -> Any:
    """Sums of each two."""
    firsts, seconds = (shuffle(builder, products, products, range(one, 2 * LANES, 2)) for one in range(2))
    return builder.add(firsts, seconds)
