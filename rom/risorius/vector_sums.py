"""The sums behind every frame, sixteen lanes at a time and in registers.

Written in LLVM's vector types, which every processor has some form of: loops over lanes, which numba leaves to the
compiler's own vectoriser, keep their sums in memory and take twice as long.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numba
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from risorius.vector_lanes import (
    FLOAT,
    INT,
    LANES,
    VECTOR,
    accumulated,
    broadcast,
    data_pointers,
    load_element,
    load_integers,
    load_vector,
    shuffle,
)

WIDTH = 4 * LANES  # components that `combine` sums at a time


def whole_blocks(size: int) -> int:
    """Number of components that `combine` sums for a field of so many."""
    return -(-size // WIDTH) * WIDTH


@numba.njit(cache=True)
def carry(starts, carriers, weights, order, rest, displacements, out):  # type: ignore[no-untyped-def]
    """Write rest + weights @ displacements into `out` (3 n), block after block of sixteen vertices.

    Block b sums over the entries starts[b]:starts[b + 1] of carriers, uint32, and weights, sixteen to an entry. order,
    uint32: vertex in each lane; one that is in several has the same weights and rest there. rest: three to a lane.
    displacements (3 m). Floats are single, all arrays contiguous and flat; numbers are not checked.
    """
    for block in range(len(starts) - 1):
        _carry_block(starts, carriers, weights, order, rest, displacements, out, block)


@numba.njit(cache=True)
def combine(fields, coordinates, out):  # type: ignore[no-untyped-def]
    """Write the sums of coordinates (r) times fields, WIDTH components of all r after each other, into `out` (m).

    Fields are single or 16-bit integers, other numbers single, all arrays contiguous; m is that of whole blocks.
    """
    for block in range(len(out) // WIDTH):
        _combine_block(fields, coordinates, out, block, len(coordinates))


@intrinsic
def least_squared(context, xs, ys, zs, start, a, b, c):  # type: ignore[no-untyped-def]
    """Least square of the distances of LANES places from (a, b, c), those from `start` on.

    Single precision, places contiguous and flat, none of them NaN.
    """
    return types.float32(xs, ys, zs, types.int64, *[types.float32] * 3), partial(_squared, "fmin")


@intrinsic
def most_squared(context, xs, ys, zs, start, a, b, c):  # type: ignore[no-untyped-def]
    """Greatest square of these distances."""
    return types.float32(xs, ys, zs, types.int64, *[types.float32] * 3), partial(_squared, "fmax")


@intrinsic
def least_product(context, xs, ys, zs, start, a, b, c):  # type: ignore[no-untyped-def]
    """Least of a x + b y + c z over these places."""

    def generate(target: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        places, factors = _places(target, builder, signature, arguments)
        products = [builder.fmul(*pair) for pair in zip(places, factors, strict=True)]
        return _reduced(builder, "fmin", _total(builder, products))

    return types.float32(xs, ys, zs, types.int64, *[types.float32] * 3), generate


@intrinsic
def sum_of_lanes(context, xs, start):  # type: ignore[no-untyped-def]
    """Sum of LANES numbers, those from `start` on; single precision, contiguous and flat."""

    def generate(target: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        (pointer,) = data_pointers(target, builder, signature.args[:1], arguments[:1])
        return _reduced(builder, "fadd", load_vector(builder, pointer, arguments[1]))

    return types.float32(xs, types.int64), generate


@intrinsic
def _combine_block(context, fields, coordinates, out, block, count):  # type: ignore[no-untyped-def]
    vector = load_vector if fields.dtype == types.float32 else load_integers
    parts = range(0, WIDTH, LANES)

    def generate(target: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        fields, coordinates, out = data_pointers(target, builder, signature.args[:3], arguments[:3])
        block, count = arguments[3:]
        first = builder.mul(builder.mul(block, count), block.type(WIDTH))

        def terms(number: Any) -> list[tuple[Any, Any]]:
            start = builder.add(first, builder.mul(number, number.type(WIDTH)))
            value = broadcast(builder, load_element(builder, coordinates, number))
            return [(value, vector(builder, fields, builder.add(start, start.type(part)))) for part in parts]

        place = builder.mul(block, block.type(WIDTH))
        for part, total in zip(parts, _sums(builder, count.type(0), count, len(parts), terms), strict=True):
            pointer = builder.gep(out, [builder.add(place, place.type(part))])
            builder.store(total, builder.bitcast(pointer, VECTOR.as_pointer()), align=4)
        return target.get_dummy_value()

    return types.void(fields, coordinates, out, types.int64, types.int64), generate


@intrinsic
def _carry_block(  # type: ignore[no-untyped-def]
    context, starts, carriers, weights, order, rest, displacements, out, block
):
    def generate(target: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        starts, carriers, weights, order, rest, displacements, out = data_pointers(
            target, builder, signature.args[:7], arguments[:7]
        )
        block = arguments[7]
        first, last = (load_element(builder, starts, block, offset) for offset in (0, 1))

        def terms(entry: Any) -> list[tuple[Any, Any]]:
            carrier = builder.mul(builder.zext(load_element(builder, carriers, entry), entry.type), entry.type(3))
            weight = load_vector(builder, weights, builder.mul(entry, entry.type(LANES)))
            return [
                (weight, broadcast(builder, load_element(builder, displacements, carrier, axis))) for axis in range(3)
            ]

        _scatter(builder, _sums(builder, first, last, 3, terms), block, order, rest, out)
        return target.get_dummy_value()

    return types.void(starts, carriers, weights, order, rest, displacements, out, types.int64), generate


def _squared(kind: str, target: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    away = [builder.fsub(*pair) for pair in zip(*_places(target, builder, signature, arguments), strict=True)]
    return _reduced(builder, kind, _total(builder, [builder.fmul(one, one) for one in away]))


def _places(target: Any, builder: Any, signature: Any, arguments: Any) -> tuple[list[Any], list[Any]]:
    """Vectors of three arrays from a start on, and three numbers in all lanes."""
    pointers = data_pointers(target, builder, signature.args[:3], arguments[:3])
    vectors = [load_vector(builder, pointer, arguments[3]) for pointer in pointers]
    return vectors, [broadcast(builder, number) for number in arguments[4:]]


def _total(builder: Any, three: list[Any]) -> Any:
    return builder.fadd(builder.fadd(three[0], three[1]), three[2])


def _reduced(builder: Any, kind: str, vector: Any) -> Any:
    """Least or greatest lane, or the sum of all, in any order."""
    name = f"llvm.vector.reduce.{kind}.v{LANES}f32"
    begun = [ir.Constant(FLOAT, 0.0)] if kind == "fadd" else []
    kinds = [FLOAT] * len(begun) + [VECTOR]
    reduced = cgutils.get_or_insert_function(builder.module, ir.FunctionType(FLOAT, kinds), name)
    return builder.call(reduced, [*begun, vector], fastmath=("nnan", "nsz", "reassoc"))


def _sums(builder: Any, first: Any, last: Any, count: int, terms: Callable[[Any], list[tuple[Any, Any]]]) -> list[Any]:
    """`count` vectors: sums over the numbers first:last of the products of the pairs that `terms` gives."""
    fused = cgutils.get_or_insert_function(
        builder.module, ir.FunctionType(VECTOR, [VECTOR] * 3), f"llvm.fma.v{LANES}f32"
    )

    def added(number: Any, totals: list[Any]) -> list[Any]:
        return [builder.call(fused, [*pair, total]) for pair, total in zip(terms(number), totals, strict=True)]

    return accumulated(builder, first, last, [ir.Constant(VECTOR, [0.0] * LANES)] * count, added)


def _scatter(builder: Any, sums: list[Any], block: Any, order: Any, rest: Any, out: Any) -> None:
    """Add the rest shape to the sums of a block and store every vertex in its place."""
    in_pairs = shuffle(builder, sums[0], sums[1], range(2 * LANES))
    third = shuffle(builder, sums[2], sums[2], range(2 * LANES))
    floats = []
    for part in range(3):
        places = [divmod(LANES * part + lane, 3) for lane in range(LANES)]
        interleaved = shuffle(builder, in_pairs, third, [LANES * axis + vertex for vertex, axis in places])
        start = builder.mul(block, block.type(3 * LANES))
        at_rest = load_vector(builder, rest, builder.add(start, block.type(LANES * part)))
        total = builder.fadd(interleaved, at_rest)
        floats += [builder.extract_element(total, INT(lane)) for lane in range(LANES)]
    lanes = builder.mul(block, block.type(LANES))
    for lane in range(LANES):
        vertex = builder.mul(builder.zext(load_element(builder, order, lanes, lane), block.type), block.type(3))
        for axis in range(3):
            place = builder.gep(out, [builder.add(vertex, block.type(axis))])
            builder.store(floats[3 * lane + axis], place)
