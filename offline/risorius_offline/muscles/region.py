"""A muscle given by its cells, with the areas of Figure 7.4 on its surface: origin, insertion and capsule."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import h5py
import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.discretisation import Discretisation, IntArray
from risorius_offline.elements import ReferenceElement
from risorius_offline.muscles.areas import Area, outer_faces
from risorius_offline.muscles.fibres import FibreField, InsertionEnd

NEGLIGIBLE = 1e-6  # a vector this small against the largest of its field has no direction to speak of


@dataclass(frozen=True)
class RegionBlock:
    """Cells of one type: connectivity (e, a), gradients (e, q, a, 3), weights (e, q), shape functions (q, a) and the
    numbers (e, q) of the points as in `FibreField`.
    """

    element: ReferenceElement
    connectivity: IntArray
    gradients: FloatArray
    weights: FloatArray
    shapes: FloatArray
    points: IntArray


@dataclass(frozen=True)
class Areas:
    """The surface of a region; a node where areas meet is a node of each of them."""

    origin: Area
    insertion: Area
    capsule: Area


@dataclass(frozen=True)
class Region:
    """cells: numbers of the cells by cell type. origin, insertion: node numbers; a face of the region's surface is of
    that area when all its nodes are, and of the capsule otherwise.
    """

    cells: Mapping[str, IntArray]
    origin: IntArray
    insertion: IntArray

    def blocks(self, discretisation: Discretisation) -> list[RegionBlock]:
        """Integration tables of the region's cells."""
        result, first = [], 0
        for block in discretisation.volumes:
            cells = self.cells.get(block.cells.cell_type, np.zeros(0, dtype=np.int64))
            per_cell = block.weights.shape[1]
            if len(cells):
                result.append(
                    RegionBlock(
                        element=block.cells.element,
                        connectivity=block.cells.connectivity[cells],
                        gradients=block.gradients[cells],
                        weights=block.weights[cells],
                        shapes=block.cells.element.shape_functions(block.cells.element.points),
                        points=first + per_cell * cells[:, None] + np.arange(per_cell),
                    )
                )
            first += block.weights.size
        if not result:
            raise InputError("its region has no cells; mark the muscle's cells")
        return result

    def areas(self, discretisation: Discretisation) -> Areas:
        """Origin, insertion and capsule.

        Raises InputError for an area without a face, areas that touch, and a part of the region without one of them.
        """
        blocks = self.blocks(discretisation)
        faces = outer_faces([(block.element, block.connectivity) for block in blocks])
        at_origin, at_insertion = (
            (np.isin(faces, nodes) | (faces < 0)).all(axis=1) for nodes in (self.origin, self.insertion)
        )
        for name, chosen in (("origin", at_origin), ("insertion", at_insertion)):
            if not chosen.any():
                raise InputError(
                    f"no face of its region's surface has all its nodes in the {name}; mark the nodes of whole faces"
                )
        parts = (at_origin, at_insertion, ~at_origin & ~at_insertion)
        found = Areas(*(Area.of(faces[chosen], discretisation.points) for chosen in parts))
        shared = np.intersect1d(found.origin.nodes, found.insertion.nodes)
        if len(shared):
            raise InputError(f"its origin and insertion share {len(shared)} node(s), first {shared[0]}; part them")
        _check_parts(blocks, found, len(discretisation.points))
        return found

    def insertion_end(self, discretisation: Discretisation) -> InsertionEnd:
        """Centroid and mean outward normal of the insertion, and the radius of a circle of its (projected) size."""
        area = self.areas(discretisation).insertion
        size = float(np.linalg.norm(area.vector))
        return InsertionEnd(area.centroid, area.vector / size, math.sqrt(size / math.pi))

    def write(self, group: h5py.Group) -> None:
        """Store cells and nodes."""
        group["origin"], group["insertion"] = self.origin, self.insertion
        for cell_type, cells in self.cells.items():
            group[f"cells/{cell_type}"] = cells

    @classmethod
    def read(cls, group: h5py.Group) -> Region:
        """Load what `write` stored."""
        cells = {cell_type: numbers[()] for cell_type, numbers in group["cells"].items()}
        return cls(cells, group["origin"][()], group["insertion"][()])


def _check_parts(blocks: list[RegionBlock], areas: Areas, node_count: int) -> None:
    """Raise InputError for a part of the region that does not join an origin to an insertion."""
    rows = np.concatenate([np.repeat(b.connectivity[:, 0], b.connectivity.shape[1]) for b in blocks])
    columns = np.concatenate([b.connectivity.ravel() for b in blocks])
    links = coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(node_count, node_count))
    part: npt.NDArray[np.int32] = connected_components(links, directed=False)[1]
    for name, area in (("origin", areas.origin), ("insertion", areas.insertion)):
        loose = np.setdiff1d(part[columns], part[area.nodes])
        if len(loose):
            node = int(columns[part[columns] == loose[0]][0])
            raise InputError(f"the part of its region around node {node} has no {name}; mark one or leave the part out")


def normalised(blocks: list[RegionBlock], vectors: list[FloatArray]) -> FibreField:
    """Unit directions of the vectors (e, q, 3) of each block.

    Points whose vector is negligible are left out, hence passive: a made-up direction would pull somewhere.
    """
    points = np.concatenate([block.points.ravel() for block in blocks])
    flat = np.concatenate([vector.reshape(-1, 3) for vector in vectors])
    length = np.linalg.norm(flat, axis=1)
    kept = length > NEGLIGIBLE * length.max()
    return FibreField(points[kept], flat[kept] / length[kept, None])
