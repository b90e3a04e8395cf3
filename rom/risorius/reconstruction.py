"""From reduced coordinates to visible vertices, x = rest + sum_k q_k basis_k, with as few bytes read as can be.

Adding up fields costs what it takes to read them. A refined surface follows a mesh that has a ninth of its points, so
the fields are added up there, and what comes out is carried to the vertices: exact, in single precision.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from risorius.carried_basis import CarriedBasis
from risorius.jaw import FloatArray
from risorius.packed_fields import PackedFields
from risorius.sizes import largest_size
from risorius.vector_lanes import LANES
from risorius.vector_sums import carry

Vertices = npt.NDArray[np.float32]
UNIT_ROUNDOFF = 2.0**-24


class Reconstruction(Protocol):
    """Writes vertices; owns what it works with, so it is not thread-safe."""

    bytes_read: int

    def write(self, coordinates: FloatArray, out: Vertices) -> None:
        """Write the vertices (n, 3) of coordinates (r,) into contiguous `out`."""
        ...

    def reach(self, coordinates: FloatArray) -> float:
        """Metres that no vertex moves further than at coordinates (r,); infinite where these are not finite."""
        ...

    def error_bound(self, coordinates: FloatArray) -> float:
        """Metres: what no component of any vertex is further off than from the exact sum (Higham 2002, 3.1)."""
        ...


def reconstruction(basis: CarriedBasis, rest: Vertices) -> Reconstruction:
    """Whichever way reads fewer bytes, for vertices at rest (n, 3)."""
    carried = CarriedReconstruction(basis, rest)
    plain = carried.bytes_of_fields if basis.carried_by_themselves else len(basis) * rest.nbytes
    return carried if carried.bytes_read < plain + rest.nbytes else PlainReconstruction(basis, rest)


class PlainReconstruction:
    """Adds up the fields of the vertices themselves."""

    def __init__(self, basis: CarriedBasis, rest: Vertices) -> None:
        self._fields = PackedFields(basis.at_vertices(), basis.coarse if basis.carried_by_themselves else None)
        self._rest = rest
        self.bytes_read = self._fields.nbytes + rest.nbytes

    def write(self, coordinates: FloatArray, out: Vertices) -> None:
        """See `Reconstruction`."""
        np.add(self._fields.combined(coordinates), self._rest.reshape(-1), out=out.reshape(-1))

    def reach(self, coordinates: FloatArray) -> float:
        """See `Reconstruction`."""
        return _reach(self._fields, coordinates)

    def error_bound(self, coordinates: FloatArray) -> float:
        """See `Reconstruction`."""
        return _rounding(len(coordinates), self._fields, 1.0, coordinates, self._rest)


class CarriedReconstruction:
    """Adds up the fields of the carrying points, and carries the sums to the vertices."""

    def __init__(self, basis: CarriedBasis, rest: Vertices) -> None:
        order = neighbours_together(rest)
        order = np.append(order, np.full(-len(order) % LANES, order[-1]))  # the last block is full, too
        self._blocks = *_in_blocks(basis.weights[order]), order.astype(np.uint32), rest[order].reshape(-1)
        self._fields = PackedFields(basis.fields, basis.coarse)
        self.bytes_of_fields = self._fields.nbytes
        self._gain = float(abs(basis.weights).sum(axis=1).max())
        self._terms = len(basis) + int(np.diff(basis.weights.indptr).max()) + 1
        self._rest = rest
        self.bytes_read = self._fields.nbytes + sum(part.nbytes for part in self._blocks)

    def write(self, coordinates: FloatArray, out: Vertices) -> None:
        """See `Reconstruction`."""
        carry(*self._blocks, self._fields.combined(coordinates), out.reshape(-1))

    def reach(self, coordinates: FloatArray) -> float:
        """See `Reconstruction`."""
        return self._gain * _reach(self._fields, coordinates)

    def error_bound(self, coordinates: FloatArray) -> float:
        """See `Reconstruction`."""
        return _rounding(self._terms, self._fields, self._gain, coordinates, self._rest)


def _reach(fields: PackedFields, coordinates: FloatArray) -> float:
    """Length of a vector whose components are all as large as the largest of the sum of the fields."""
    if not np.isfinite(coordinates).all():
        return math.inf
    return math.sqrt(3.0) * float(largest_size(fields.combined(coordinates)))


def _rounding(terms: int, fields: PackedFields, gain: float, coordinates: FloatArray, rest: Vertices) -> float:
    """Bound for a sum of products of coordinates and fields, times weights that add up to `gain`, and a place at rest:
    2 for q and the last +.
    """
    size = gain * float(np.abs(coordinates) @ fields.largest)
    of_sums = UNIT_ROUNDOFF * (1.01 * (terms + 2) * size + float(np.abs(rest).max()))
    return of_sums + gain * fields.rounding(coordinates)


def neighbours_together(points: Vertices) -> npt.NDArray[np.int64]:
    """Numbers of the points (n, 3) in an order in which every LANES are close: halves along the longest side."""
    groups, pending = [], [np.arange(len(points))]
    while pending:
        group = pending.pop()
        if len(group) <= LANES:
            groups.append(group)
            continue
        places = points[group]
        along = places[:, np.ptp(places, axis=0).argmax()]
        half = LANES * -(-len(group) // (2 * LANES))
        group = group[np.argpartition(along, half - 1)] if half < len(group) else group
        pending += [group[half:], group[:half]]
    return np.concatenate(groups)


def _in_blocks(weights: sp.csr_matrix) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.uint32], npt.NDArray[np.float32]]:
    """Starts, carriers and weights of `carry` for rows of vertices in their order, LANES to a block."""
    table = weights.tocoo()
    carriers = table.shape[1]
    keys, entry = np.unique(table.row // LANES * carriers + table.col, return_inverse=True)
    packed = np.zeros((len(keys), LANES), np.float32)
    packed[entry, table.row % LANES] = table.data
    starts = np.searchsorted(keys, carriers * np.arange(table.shape[0] // LANES + 1))
    return starts, (keys % carriers).astype(np.uint32), packed.reshape(-1)
