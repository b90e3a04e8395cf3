"""Planes between the lips: what has stayed on its side of them on its straight way from rest touches nothing.

Triangles of either lip are in groups some millimetres wide. Between a group and one of the other lip there is a plane
at rest, and its normal is kept. Hulls that the normal still tells apart, the same way round, have not crossed on the
straight way from rest: on it distances along a fixed direction change linearly. Groups whose spheres do not meet
anywhere on that way have not, either. Nothing is told of points around a lip's rim, where they may get behind it
without crossing it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numba
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from risorius.effects.contact_tables import ContactTables
from risorius.vector_lanes import LANES

Numbers = npt.NDArray[np.int32]
Floats = npt.NDArray[np.float32]

WIDTH = 5e-3  # metres from the middle of a group to its triangles
FACING = 10e-3  # metres at rest, beyond which no plane is kept between groups
RIM = 4e-3  # metres at rest from where the other lip ends, around which a point may get behind it
STEPS = 1000  # of Gilbert's algorithm: margins are then within some hundredths of the best

_compiled = numba.njit(cache=True, error_model="numpy")


@dataclass(frozen=True)
class LipGroups:
    """Groups of the triangles of lips, those of one side first.

    members (N,): vertices of the groups, the middle one first, LANES or a multiple of it to a group, some repeated;
    starts (g + 1,); split: number of groups of the first side. middles (3, g), radii (g,) at rest. planes (k, 3):
    normals from groups of the second side towards those of the first; plane_of (split, g - split), -1 without one.
    group_of (n,): of every vertex, -1 of those of which nothing is told.
    """

    members: Numbers
    starts: Numbers
    split: int
    middles: Floats
    radii: Floats
    planes: Floats
    plane_of: Numbers
    group_of: Numbers

    @classmethod
    def of(cls, tables: ContactTables, rest: Floats) -> LipGroups:
        """Groups of tables, for vertices at rest (n, 3)."""
        sides = lip_sides(tables)
        group, first, count = _grouped(rest[tables.triangles].mean(axis=1), sides[tables.triangles[:, 0]])
        corners = [np.unique(tables.triangles[group == number]) for number in range(count)]
        members = [_padded(rest, vertices) for vertices in corners]
        starts = np.cumsum([0, *map(len, members)])
        group_of = np.full(len(rest), -1, np.int32)
        for number, vertices in enumerate(corners):
            group_of[vertices] = number
        group_of[_near_rim(tables, sides, rest)] = -1
        flat = np.concatenate([np.zeros(0, np.int32), *members])
        radii = [float(np.linalg.norm(rest[one] - rest[one[0]], axis=1).max()) for one in members]
        near = _near(rest, corners, first)
        planes = np.zeros((len(near), 3), np.float32)
        _separate(rest.astype(np.float64), flat, starts, near, planes)
        plane_of = np.full((first, count - first), -1, np.int32)
        plane_of[near[:, 0], near[:, 1] - first] = np.arange(len(near))
        return cls(
            members=flat,
            starts=starts.astype(np.int32),
            split=first,
            middles=np.ascontiguousarray(rest[flat[starts[:-1]]].T, np.float32),
            radii=np.array(radii, np.float32),
            planes=planes,
            plane_of=plane_of,
            group_of=group_of,
        )

    def kernel(self, vertices: Numbers) -> tuple[Any, ...]:
        """What `beyond_planes` reads, and what it works with, for vertices (l,) of the lips."""
        count, of_points = len(self.radii), self.group_of[vertices]
        order = np.argsort(of_points, kind="stable").astype(np.int32)
        starts = np.searchsorted(of_points[order], np.arange(count + 1)).astype(np.int32)
        others = np.flatnonzero(of_points < 0).astype(np.int32)
        return (
            self.members, self.starts, self.split, self.middles, self.radii, self.planes, self.plane_of, starts, order,
            others, np.zeros((3, len(self.members)), np.float32),
            np.zeros((3, count), np.float32), np.zeros(count, np.float32), np.zeros(count, np.float32),
            np.zeros((self.split, count - self.split), np.float32),
        )  # fmt: skip


def _near_rim(tables: ContactTables, sides: Numbers, rest: Floats) -> Numbers:
    """Vertices of the lips that are next to where the other lip ends."""
    lips = np.unique(tables.triangles)
    ends = np.concatenate([tables.triangles[tables.across[:, k] < 0][:, [k, (k + 1) % 3]] for k in range(3)])
    found = [np.zeros(0, np.int32)]
    for side in (0, 1):
        rim, mine = np.unique(ends[sides[ends] == 1 - side]), lips[sides[lips] == side]
        if len(rim):
            found.append(mine[cKDTree(rest[rim]).query(rest[mine])[0] < RIM])
    return np.concatenate(found)


def lip_sides(tables: ContactTables) -> Numbers:
    """(n,) for each vertex number one of a lip, its side 0 or 1, -1 where none is known: what faces is opposite."""
    count, corners = len(tables.row_starts) - 1, tables.triangles
    if not len(tables.vertices):
        return np.full(count, -1, np.int32)
    faced = corners[tables.facing, 0]
    same = np.concatenate([corners[:, [0, 1]], corners[:, [0, 2]]])
    pairs = np.concatenate(
        [same, same + count, np.column_stack([tables.vertices, faced + count]),
         np.column_stack([tables.vertices + count, faced])]
    )  # fmt: skip
    linked = sp.coo_matrix((np.ones(len(pairs), bool), pairs.T), shape=(2 * count, 2 * count))
    label = connected_components(linked, directed=False)[1]
    first = label[tables.vertices[0]]
    return np.where(label[:count] == first, 0, np.where(label[count:] == first, 1, -1)).astype(np.int32)


def _grouped(centres: Floats, sides: Numbers) -> tuple[npt.NDArray[np.int64], int, int]:
    """Group (t,) of triangles with centres (t, 3), -1 of no side, number of those of side 0, and of all groups."""
    group, counts = np.full(len(centres), -1), [0]
    for side in (0, 1):
        mine = np.flatnonzero(sides == side)
        if len(mine):
            chosen = _spread(centres[mine])
            group[mine] = counts[-1] + cKDTree(centres[mine[chosen]]).query(centres[mine])[1]
            counts.append(counts[-1] + len(chosen))
        else:
            counts.append(counts[-1])
    return group, counts[1], counts[2]


def _spread(places: Floats) -> list[int]:
    """Numbers of places, each the farthest from those before, until none is farther than WIDTH."""
    chosen, away = [0], np.linalg.norm(places - places[0], axis=1)
    while away.max() > WIDTH:
        chosen.append(int(away.argmax()))
        away = np.minimum(away, np.linalg.norm(places - places[chosen[-1]], axis=1))
    return chosen


def _padded(rest: Floats, vertices: Numbers) -> Numbers:
    """Vertices, that nearest to the middle of all first, which is repeated up to whole LANES."""
    places = rest[vertices]
    middle = np.linalg.norm(places - 0.5 * (places.min(axis=0) + places.max(axis=0)), axis=1).argmin()
    ordered = np.concatenate([vertices[[middle]], np.delete(vertices, middle)])
    return np.append(ordered, np.full(-len(ordered) % LANES, ordered[0])).astype(np.int32)


def _near(rest: Floats, corners: list[Numbers], first: int) -> npt.NDArray[np.int64]:
    """(k, 2) pairs of groups of either side that come within FACING at rest."""
    others = corners[first:]
    if not first or not others:
        return np.zeros((0, 2), np.int64)
    number = np.repeat(np.arange(first, len(corners)), [len(one) for one in others])
    tree, pairs = cKDTree(rest[np.concatenate(others)]), list[tuple[int, int]]()
    for group, vertices in enumerate(corners[:first]):
        found = tree.query_ball_point(rest[vertices], FACING)
        pairs += [(group, int(other)) for other in np.unique(number[np.concatenate(found).astype(np.int64)])]
    return np.array(pairs, np.int64).reshape(-1, 2)


@_compiled
def _separate(rest, members, starts, pairs, planes):  # type: ignore[no-untyped-def]
    """Set unit normals (k, 3) that tell groups apart best, between the nearest points of their hulls (Gilbert 1966).

    Hulls that meet leave one that tells little or nothing.
    """
    for k in range(len(pairs)):
        a, b = pairs[k]
        p, q = members[starts[a]], members[starts[b]]
        x, y, z = rest[p, 0] - rest[q, 0], rest[p, 1] - rest[q, 1], rest[p, 2] - rest[q, 2]
        for _ in range(STEPS):
            least, most = np.inf, -np.inf
            for i in range(starts[a], starts[a + 1]):
                product = x * rest[members[i], 0] + y * rest[members[i], 1] + z * rest[members[i], 2]
                if product < least:
                    least, p = product, members[i]
            for i in range(starts[b], starts[b + 1]):
                product = x * rest[members[i], 0] + y * rest[members[i], 1] + z * rest[members[i], 2]
                if product > most:
                    most, q = product, members[i]
            u, v, w = rest[p, 0] - rest[q, 0] - x, rest[p, 1] - rest[q, 1] - y, rest[p, 2] - rest[q, 2] - z
            square = u * u + v * v + w * w
            step = -(x * u + y * v + z * w) / max(square, 1e-30)
            if step <= 1e-6:
                break
            step = min(step, 1.0)
            x, y, z = x + step * u, y + step * v, z + step * w
        length = max(math.sqrt(x * x + y * y + z * z), 1e-12)
        planes[k, 0], planes[k, 1], planes[k, 2] = x / length, y / length, z / length
