"""A body as tables: what the integrals of its energy are summed over, without the mesh that they come from.

Snapshots keep the body of their face, so that reduced models can be trained with its physics.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from risorius import storage
from risorius.jaw import FloatArray

IntArray = npt.NDArray[np.int64]


@dataclass(frozen=True)
class PassiveElements:
    """Elements of one kind, as in `mechanics.elements`.

    connectivity (e, a), gradients (e, q, a, 3) per metre, weights (e, q) cubic metres, coefficients (e, 3) pascals.
    """

    connectivity: IntArray
    gradients: FloatArray
    weights: FloatArray
    coefficients: FloatArray

    def weighted(self, chosen: IntArray, weights: FloatArray) -> PassiveElements:
        """Return chosen elements (k,), each counted `weights` (k,) times."""
        return PassiveElements(
            self.connectivity[chosen],
            self.gradients[chosen],
            self.weights[chosen] * weights[:, None],
            self.coefficients[chosen],
        )


@dataclass(frozen=True)
class WallCells:
    """Cells of one kind that have a wall, as in `mechanics.wall`.

    connectivity (e, a), corners (e, a, 3) at rest in metres, gradients (a, 3, k), form (m, k), heights (e, m) cubic
    metres, weights (e,) joules.
    """

    connectivity: IntArray
    corners: FloatArray
    gradients: FloatArray
    form: FloatArray
    heights: FloatArray
    weights: FloatArray

    def weighted(self, chosen: IntArray, weights: FloatArray) -> WallCells:
        """Return chosen cells (k,), each counted `weights` (k,) times."""
        return replace(
            self,
            connectivity=self.connectivity[chosen],
            corners=self.corners[chosen],
            heights=self.heights[chosen],
            weights=self.weights[chosen] * weights,
        )


@dataclass(frozen=True)
class Body:
    """Tissue with its muscles and walls.

    prescribed: (n,) whether a node moves with a bone. active: (6 points, muscles) sparse, tensors (xx, yy, zz, xy, yz,
    zx) in pascals at full activation, points in the order of the passive elements that come first. dead_loads:
    (3 n, muscles) sparse, newtons at full activation.
    """

    passive: tuple[PassiveElements, ...]
    walls: tuple[WallCells, ...]
    active: sp.csr_matrix
    dead_loads: sp.csr_matrix
    prescribed: npt.NDArray[np.bool_]

    def write(self, group: h5py.Group) -> None:
        """Store all tables."""
        write_tables(group, "passive", self.passive)
        write_tables(group, "walls", self.walls)
        storage.write_sparse(group.create_group("active"), self.active)
        storage.write_sparse(group.create_group("dead_loads"), self.dead_loads)
        group["prescribed"] = self.prescribed

    @classmethod
    def read(cls, group: h5py.Group) -> Body:
        """Load what `write` stored."""
        return cls(
            passive=tuple(PassiveElements(**table) for table in read_tables(group, "passive")),
            walls=tuple(WallCells(**table) for table in read_tables(group, "walls")),
            active=storage.read_sparse(group["active"]),
            dead_loads=storage.read_sparse(group["dead_loads"]),
            prescribed=group["prescribed"][()],
        )


def write_tables(group: h5py.Group, name: str, tables: Sequence[PassiveElements | WallCells]) -> None:
    """Store tables, numbered, in a group of that name."""
    for number, table in enumerate(tables):
        stored = group.create_group(f"{name}/{number}")
        for item in fields(table):
            values = getattr(table, item.name)
            stored.create_dataset(item.name, data=values, compression="gzip", compression_opts=1, shuffle=True)


def read_tables(group: h5py.Group, name: str) -> Iterator[dict[str, npt.NDArray[Any]]]:
    """Load the fields of what `write_tables` stored."""
    for number in range(len(group.get(name, ()))):
        yield {key: values[()] for key, values in group[f"{name}/{number}"].items()}
