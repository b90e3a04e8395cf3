"""Questions that sixteen lanes answer at a time, a bit to each: bit k is of lane k."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic

from risorius.vector_lanes import LANES, broadcast, data_pointers, load_vector

_BITS = ir.IntType(LANES)


@intrinsic
def lanes_within(context, xs, ys, zs, radii, start, a, b, c, reach):  # type: ignore[no-untyped-def]
    """Which spheres come within reach of (a, b, c), of the LANES from `start` on; none of them is NaN.

    Single precision, spheres contiguous and flat.
    """

    def generate(target: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointers = data_pointers(target, builder, signature.args[:4], arguments[:4])
        *places, sizes = [load_vector(builder, pointer, arguments[4]) for pointer in pointers]
        away = [builder.fsub(x, broadcast(builder, y)) for x, y in zip(places, arguments[5:8], strict=True)]
        most = builder.fadd(sizes, broadcast(builder, arguments[8]))
        square = _sum(builder, [builder.fmul(one, one) for one in away])
        return _mask(builder, builder.fcmp_ordered("<", square, builder.fmul(most, most)))

    return types.int64(xs, ys, zs, radii, types.int64, *[types.float32] * 4), generate


@intrinsic
def lanes_behind(context, xs, ys, zs, offsets, start, a, b, c):  # type: ignore[no-untyped-def]
    """Behind which planes (a, b, c) lies, of LANES with normals x, y, z and offsets, those from `start` on.

    Single precision, planes contiguous and flat.
    """

    def generate(target: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointers = data_pointers(target, builder, signature.args[:4], arguments[:4])
        *normals, beyond = [load_vector(builder, pointer, arguments[4]) for pointer in pointers]
        place = [broadcast(builder, number) for number in arguments[5:]]
        height = _sum(builder, [builder.fmul(*pair) for pair in zip(normals, place, strict=True)])
        return _mask(builder, builder.fcmp_ordered("<", height, beyond))

    return types.int64(xs, ys, zs, offsets, types.int64, *[types.float32] * 3), generate


@intrinsic
def first_lane(context, mask):  # type: ignore[no-untyped-def]
    """Lowest bit of a mask that is set; there is one."""

    def generate(target: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.cttz(arguments[0], ir.IntType(1)(1))

    return types.int64(types.int64), generate


def _sum(builder: Any, three: list[Any]) -> Any:
    return builder.fadd(builder.fadd(three[0], three[1]), three[2])


def _mask(builder: Any, flags: Any) -> Any:
    return builder.zext(builder.bitcast(flags, _BITS), ir.IntType(64))
