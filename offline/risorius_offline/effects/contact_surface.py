"""The boundary of a mesh as a surface that can touch itself: nodes, triangles, neighbours and areas."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from risorius.adjacency import triangles_across, vertex_fans
from risorius.jaw import FloatArray
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.anatomy.surface import as_triangles, boundary_faces
from risorius_offline.discretisation import IntArray
from risorius_offline.effects.point_triangle import CORNERS, EDGES, TRIANGLE, compiled


@dataclass(frozen=True)
class ContactSurface:
    """Boundary in its own numbering: row i of every array by node is node nodes[i] of the mesh.

    nodes (b,); points (b, 3) at rest, metres; areas (b,) a third of the triangles around each node, square metres;
    bone (b,) flags of the prescribed nodes. triangles (m, 3), outward; across (m, 3) the triangle beyond the edge from
    corner k to the next, -1 where not exactly two meet; fans lists the triangles around each node, from fan_starts[i]
    to fan_starts[i + 1].
    """

    nodes: IntArray
    points: FloatArray
    areas: FloatArray
    bone: npt.NDArray[np.bool_]
    triangles: IntArray
    across: IntArray
    fans: IntArray
    fan_starts: IntArray

    @classmethod
    def of(cls, anatomy: Anatomy) -> ContactSurface:
        """Boundary of all cells of an anatomy."""
        nodes, flat = np.unique(as_triangles(boundary_faces(anatomy.cells), anatomy.points), return_inverse=True)
        surface = cls.of_triangles(anatomy.points[nodes], flat.reshape(-1, 3))
        return replace(surface, nodes=nodes, bone=anatomy.prescribed[nodes])

    @classmethod
    def of_triangles(cls, points: FloatArray, triangles: IntArray) -> ContactSurface:
        """Surface of triangles (m, 3) between points (b, 3), all of which move freely; it may be open."""
        triangles = np.ascontiguousarray(triangles, dtype=np.int64)
        points = np.ascontiguousarray(points)
        a, b, c = np.moveaxis(points[triangles], 1, 0)
        third = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6.0
        areas = np.zeros(len(points))
        np.add.at(areas, triangles, third[:, None])
        around, starts = vertex_fans(triangles, len(points))
        return cls(
            nodes=np.arange(len(points)),
            points=points,
            areas=areas,
            bone=np.zeros(len(points), dtype=bool),
            triangles=triangles,
            across=triangles_across(triangles),
            fans=around,
            fan_starts=starts,
        )


@compiled
def admitted(p, t, triangles, bone):  # type: ignore[no-untyped-def]
    """Whether node p can touch triangle t: it is not one of its corners, and not all four nodes are on bone."""
    a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    return p != a and p != b and p != c and not (bone[p] and bone[a] and bone[b] and bone[c])


@compiled
def multiplicity(p, t, feature, triangles, bone, across, fans, fan_starts):  # type: ignore[no-untyped-def]
    """How often a feature of triangle t counts for node p: 1 for the triangle, -1 for an edge, 1 for a corner.

    An edge between two admitted triangles would count twice and is taken off once, by the lower numbered of them; a
    corner in a full circle of admitted triangles, whose edges then take off too much, is put back by the first.
    """
    if feature == TRIANGLE:
        return 1.0
    if feature < CORNERS[0]:
        other = across[t, feature - EDGES[0]]
        return -1.0 if other > t and admitted(p, other, triangles, bone) else 0.0
    corner = triangles[t, feature - CORNERS[0]]
    start, end = fan_starts[corner], fan_starts[corner + 1]
    if fans[start] != t:
        return 0.0
    for k in range(start, end):
        if not admitted(p, fans[k], triangles, bone):
            return 0.0
    return 1.0
