"""Vectors of sixteen single-precision lanes, as LLVM has them: what intrinsics are built from."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir

LANES = 16
FLOAT, INT, SHORT = ir.FloatType(), ir.IntType(32), ir.IntType(16)
VECTOR = ir.VectorType(FLOAT, LANES)


def data_pointers(target: Any, builder: Any, kinds: Any, arrays: Any) -> list[Any]:
    """Pointers to the numbers of arrays of numba, of these kinds."""
    return [target.make_array(kind)(target, builder, value).data for kind, value in zip(kinds, arrays, strict=True)]


def load_element(builder: Any, array: Any, number: Any, offset: int = 0) -> Any:
    """One number of an array."""
    return builder.load(builder.gep(array, [builder.add(number, number.type(offset))]))


def load_vector(builder: Any, array: Any, number: Any) -> Any:
    """Numbers of an array, from one on."""
    return builder.load(builder.bitcast(builder.gep(array, [number]), VECTOR.as_pointer()), align=4)


def load_integers(builder: Any, array: Any, number: Any) -> Any:
    """16-bit numbers of an array, from one on, as single precision."""
    pointer = builder.bitcast(builder.gep(array, [number]), ir.VectorType(SHORT, LANES).as_pointer())
    return builder.sitofp(builder.load(pointer, align=2), VECTOR)


def broadcast(builder: Any, value: Any) -> Any:
    """One number in all lanes."""
    single = builder.insert_element(ir.Constant(VECTOR, ir.Undefined), value, INT(0))
    return shuffle(builder, single, single, [0] * LANES)


def shuffle(builder: Any, first: Any, second: Any, places: Any) -> Any:
    """Lanes of two vectors, those of the second after those of the first, in places."""
    mask = ir.Constant(ir.VectorType(INT, len(places)), list(places))
    return builder.shuffle_vector(first, second, mask)


def accumulated(
    builder: Any, first: Any, last: Any, begun: list[Any], added: Callable[[Any, list[Any]], list[Any]]
) -> list[Any]:
    """Totals after a loop over the numbers first:last, of which each makes new ones of those before."""
    before = builder.block
    head, body, after = (builder.append_basic_block() for _ in range(3))
    builder.branch(head)
    builder.position_at_end(head)
    number = builder.phi(first.type)
    totals = [builder.phi(one.type) for one in begun]
    builder.cbranch(builder.icmp_signed("<", number, last), body, after)
    builder.position_at_end(body)
    number.add_incoming(first, before)
    number.add_incoming(builder.add(number, number.type(1)), body)
    for total, start, next_one in zip(totals, begun, added(number, totals), strict=True):
        total.add_incoming(start, before)
        total.add_incoming(next_one, body)
    builder.branch(head)
    builder.position_at_end(after)
    return totals
