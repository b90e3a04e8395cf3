"""What the kernels of contact read, and how it is made from a model and what its skin can touch."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
from scipy.spatial import cKDTree

from risorius.companion import JAW, unit_transforms
from risorius.contact_geometry import ContactGeometry
from risorius.effects.correction_fields import beside_middle, correction_shares, outwards
from risorius.effects.teeth_blocks import BLOCK, blocks
from risorius.effects.teeth_gaps import move_jaw
from risorius.jaw import FloatArray
from risorius.lip_sheets import LipSheets
from risorius.normals import vertex_normals
from risorius.part import Part
from risorius.penetration import PenetrationMeasure
from risorius.poses import Poses
from risorius.snapshot_file import SnapshotSet

Vertices = npt.NDArray[np.float32]
Frames = Iterable[tuple[FloatArray, Vertices]]
"""Lift coordinates of the poses, and vertices (n, 3), of each."""

MOST_REACHED = 760  # points that are kept first, for teeth: where frames come nearest
MOST_POINTS = 2400  # others
MOST_FRAMES = 150  # of training, at which it is seen what may touch
REACHED = 2.5e-3  # metres: a vertex that comes as near as that to a tooth is one of the first
NEAR = 5.9e-3  # metres: a vertex that never comes as near as that to a tooth does not touch it in a reduced model
FINEST = 0.3e-3  # metres between points
TURNED = (
    2e-3  # metres that two points at one place, with normals a right angle apart, count as being apart, over root 2
)
DEEPEST_AT_REST = 1e-3  # metres: what is deeper in a tooth at rest has no contact with it
OUT_OF_THE_FACE = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class ContactTables:
    """What the kernels read; vertex numbers are the model's.

    Points that may touch teeth: points (k,), onset (k, o): distance to each obstacle at which contact begins, below
    -1 m where there is none; away (k, o, 3): the way out at rest. Obstacles: distances (all grids, flat), starts (o,),
    shapes (o, 3), lows (o, 3), spacings (o,), moves (o,), and transforms (q, 4, 4) of the jaw as of a companion.
    Lips: vertices (l,) that may touch, facing (l,) a triangle at rest, places (l, 3) at rest; triangles (t, 3), across
    (t, 3), planes (t, 4) at rest. Shares of vertices in correction fields, by rows and by columns. orientation: 1, or
    -1 where the order of axes turns triangles over.
    """

    points: npt.NDArray[np.int32]
    onset: npt.NDArray[np.float32]
    away: npt.NDArray[np.float32]
    distances: npt.NDArray[np.float32]
    starts: npt.NDArray[np.int64]
    shapes: npt.NDArray[np.int64]
    lows: FloatArray
    spacings: FloatArray
    moves: npt.NDArray[np.bool_]
    transforms: FloatArray
    vertices: npt.NDArray[np.int32]
    facing: npt.NDArray[np.int32]
    places: npt.NDArray[np.float32]
    triangles: npt.NDArray[np.int32]
    across: npt.NDArray[np.int32]
    planes: npt.NDArray[np.float32]
    row_starts: npt.NDArray[np.int32]
    row_controls: npt.NDArray[np.int32]
    row_shares: npt.NDArray[np.float32]
    column_starts: npt.NDArray[np.int32]
    column_vertices: npt.NDArray[np.int32]
    column_shares: npt.NDArray[np.float32]
    orientation: npt.NDArray[np.int64]

    @cached_property
    def shares(self) -> sp.csr_matrix:
        """Shares (n, c) of vertices in correction fields."""
        shape = len(self.row_starts) - 1, len(self.column_starts) - 1
        return sp.csr_matrix((self.row_shares, self.row_controls, self.row_starts), shape=shape)

    @cached_property
    def least(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.int64]]:
        """Least distances of the blocks of all grids, then those beyond each grid; where those of each grid start."""
        parts, beyond = [np.zeros(0, np.float32)], []
        for start, shape in zip(self.starts, self.shapes, strict=True):
            grid = self.distances[start : start + shape.prod()].reshape(shape)
            rim = [np.take(grid, (0, -1), axis) for axis in range(3)]
            beyond.append(min(float(side.min()) for side in rim))
            for axis in range(3):
                first = BLOCK * np.arange(blocks(shape[axis]))
                inner = np.minimum.reduceat(grid, first, axis)
                grid = np.minimum(inner, np.take(grid, np.minimum(first + BLOCK, shape[axis] - 1), axis))
            parts.append(grid.ravel())
        starts = np.cumsum([len(part) for part in parts])[:-1].astype(np.int64)
        return np.concatenate([*parts, np.array(beyond, np.float32)]), starts

    def within(self, part: Part) -> ContactTables:
        """Tables of a part of the model. Lips of which it does not hold all triangles around a vertex do not meet."""
        number = np.full(len(self.row_starts) - 1, -1, np.int32)
        number[part.vertices] = np.arange(len(part.vertices))
        points = number[self.points] >= 0
        whole = np.asarray((number[self.triangles] >= 0).all(axis=1))
        new = np.where(whole, np.cumsum(whole) - 1, -1).astype(np.int32)
        vertices = (number[self.vertices] >= 0) & whole[self.facing]
        return replace(
            self,
            points=number[self.points[points]],
            onset=self.onset[points],
            away=self.away[points],
            transforms=self.transforms if 0 in part.lifts else self.transforms[:0],
            vertices=number[self.vertices[vertices]],
            facing=new[self.facing[vertices]],
            places=self.places[vertices],
            triangles=number[self.triangles[whole]],
            across=np.where(self.across[whole] >= 0, new[self.across[whole]], -1).astype(np.int32),
            planes=self.planes[whole],
            **_shares(self.shares[part.vertices]),
        )

    def only(self, points: npt.NDArray[np.bool_], vertices: npt.NDArray[np.bool_]) -> ContactTables:
        """Tables of some of the points (k,) that may touch teeth, and some of the vertices (l,) of the lips."""
        return replace(
            self,
            points=self.points[points],
            onset=self.onset[points],
            away=self.away[points],
            vertices=self.vertices[vertices],
            facing=self.facing[vertices],
            places=self.places[vertices],
        )

    def jaw(self, coordinates: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Turn (3, 3) and origin (3,) of the jaw's teeth at coordinates (r,): they are at turn @ place + origin."""
        turn, origin = np.empty((3, 3)), np.empty(3)
        move_jaw(coordinates, self.transforms, turn, origin)
        return turn, origin

    def in_axes(self, order: tuple[int, int, int]) -> ContactTables:
        """Tables for vertices whose components are in another order."""
        axes = list(order)
        grids = [
            self.distances[start : start + shape.prod()].reshape(shape).transpose(axes).ravel()
            for start, shape in zip(self.starts, self.shapes, strict=True)
        ]
        turned = np.eye(4)[[*axes, 3]]
        return replace(
            self,
            away=np.ascontiguousarray(self.away[..., axes]),
            distances=np.concatenate(grids) if grids else self.distances,
            shapes=np.ascontiguousarray(self.shapes[:, axes]),
            lows=np.ascontiguousarray(self.lows[:, axes]),
            transforms=turned @ self.transforms @ turned.T,
            places=np.ascontiguousarray(self.places[:, axes]),
            planes=np.ascontiguousarray(self.planes[:, [*axes, 3]]),
            orientation=self.orientation * round(np.linalg.det(turned)),
        )


def contact_tables(
    geometry: ContactGeometry, poses: Poses, rest: Vertices, triangles: npt.NDArray[np.int32], frames: Frames
) -> ContactTables:
    """Tables for a surface at rest (n, 3), triangles (m, 3); what comes near nothing in any frame is left out.

    Of the lips all vertices are kept: what touches between points that are looked at is seen by none of them.
    """
    sheets = LipSheets.of(geometry.seam, rest, triangles)
    reached, near, meet = _reached(PenetrationMeasure(geometry, poses, rest, triangles), frames)
    near[:, sheets.vertices] = True
    normals = vertex_normals(rest, triangles).astype(np.float64)
    first = _thinned(rest, normals, np.flatnonzero(reached.any(axis=0)), MOST_REACHED)
    points = np.union1d(first, _thinned(rest, normals, np.flatnonzero(near.any(axis=0)), MOST_POINTS))
    lips = slice(None) if meet else slice(0)
    vertices = sheets.vertices[lips]
    return ContactTables(
        points=points.astype(np.int32),
        **_of_obstacles(geometry, poses, rest[points], near[:, points]),
        vertices=vertices,
        facing=sheets.facing[lips],
        places=rest[vertices],
        triangles=sheets.triangles,
        across=sheets.across,
        planes=_planes(rest, sheets.triangles),
        **_shares(correction_shares(rest, triangles, np.union1d(points, vertices))),
        orientation=np.ones(1, dtype=np.int64),
    )


def frames_of(snapshots: SnapshotSet) -> Frames:
    """Some of the training snapshots, as they are seen."""
    used = np.flatnonzero(~snapshots.held_out)
    for row in used[:: max(1, len(used) // MOST_FRAMES)]:
        displacement = snapshots.surface.weights @ snapshots.displacements[row].astype(np.float64)
        lifts = snapshots.poses.lift_coordinates(snapshots.parameters[row, len(snapshots.muscles) :])
        yield lifts, (snapshots.surface.points + displacement).astype(np.float32)


def _reached(measure: PenetrationMeasure, frames: Frames) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_], bool]:
    """Vertices (o, n) that come within REACHED and within NEAR of an obstacle, and whether lips meet each other."""
    seen = [
        (measure.depths_in_obstacles(vertices, lifts), measure.depths_in_lips(vertices).max(initial=0.0))
        for lifts, vertices in frames
    ]
    deepest, met = (np.max(depths, axis=0) for depths in zip(*seen, strict=True))
    return deepest > -REACHED, deepest > -NEAR, bool(met > 0.0)


def _thinned(
    rest: npt.NDArray[np.float32], normals: FloatArray, among: npt.NDArray[np.integer], most: int
) -> npt.NDArray[np.integer]:
    """At most so many of the vertices, evenly spread; on both sides of the plane of symmetry alike.

    What faces another way is another place: lips that touch at rest both get theirs.
    """
    among = among[outwards(rest[among].astype(np.float64))]
    places = np.hstack([rest[among], TURNED * normals[among]])
    chosen, spacing = among, FINEST
    while len(chosen) > most:
        tree, free = cKDTree(places), ~beside_middle(places, spacing)
        kept = []
        for number in range(len(among)):
            if free[number]:
                kept.append(number)
                free[tree.query_ball_point(places[number], spacing)] = False
        chosen, spacing = among[kept], 1.1 * spacing
    return np.sort(chosen)


def _of_obstacles(
    geometry: ContactGeometry, poses: Poses, places: npt.NDArray[np.float32], touched: npt.NDArray[np.bool_]
) -> dict[str, Any]:
    """Tables of the obstacles, for points at places (k, 3) at rest that touch some of them (o, k)."""
    obstacles = list(geometry.obstacles.values())
    onset = np.full((len(places), len(obstacles)), -2.0, np.float32)
    away = np.zeros((len(places), len(obstacles), 3), np.float32)
    for number, obstacle in enumerate(obstacles):
        gap, slope = obstacle.distance(places), obstacle.slope(places)
        onset[:, number] = np.where(touched[number] & (gap > -DEEPEST_AT_REST), np.minimum(gap, 0.0), -2.0)
        away[:, number] = np.where(np.linalg.norm(slope, axis=1, keepdims=True) > 0.1, slope, OUT_OF_THE_FACE)
    sizes = [obstacle.distances.size for obstacle in obstacles]
    jaw = np.zeros((0, 4, 4)) if poses.jaw is None else unit_transforms(poses.jaw)
    return {
        "onset": onset,
        "away": away,
        "distances": np.concatenate([np.zeros(0, np.float32), *(obstacle.distances.ravel() for obstacle in obstacles)]),
        "starts": np.cumsum([0, *sizes])[:-1].astype(np.int64),
        "shapes": np.array([obstacle.distances.shape for obstacle in obstacles], np.int64).reshape(-1, 3),
        "lows": np.array([obstacle.origin for obstacle in obstacles], float).reshape(-1, 3),
        "spacings": np.array([obstacle.spacing for obstacle in obstacles], float),
        "moves": np.array([obstacle.moves_with == JAW for obstacle in obstacles], bool),
        "transforms": jaw,
    }


def _planes(rest: npt.NDArray[np.float32], triangles: npt.NDArray[np.int32]) -> npt.NDArray[np.float32]:
    """(t, 4): outward normal, and its product with a corner."""
    a, b, c = (rest[triangles[:, corner]].astype(np.float64) for corner in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    return np.column_stack([normal, np.einsum("ti,ti->t", normal, a)]).astype(np.float32)


def _shares(rows: sp.csr_matrix) -> dict[str, Any]:
    """Shares (n, c) by rows and by columns."""
    columns = sp.csr_matrix(rows.T)
    return {
        "row_starts": rows.indptr.astype(np.int32),
        "row_controls": rows.indices.astype(np.int32),
        "row_shares": rows.data.astype(np.float32),
        "column_starts": columns.indptr.astype(np.int32),
        "column_vertices": columns.indices.astype(np.int32),
        "column_shares": columns.data.astype(np.float32),
    }
