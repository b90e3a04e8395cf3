"""Areas on the surface of a muscle: their faces, nodes and normals."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray
from risorius_offline.elements import ReferenceElement

NODES_PER_FACE = 6  # of the largest face, a quadratic triangle; smaller ones are padded with -1
CANCELLED = 1e-6  # a sum of normals this small against the largest is none


@dataclass(frozen=True)
class Area:
    """Faces of a region's surface: their nodes (k,) with unit outward normals (k, 3), averaged over the faces of this
    area only; its vector (3,), the integral of the normal, m^2; its centroid (3,).
    """

    nodes: IntArray
    normals: FloatArray
    vector: FloatArray
    centroid: FloatArray

    @classmethod
    def of(cls, faces: IntArray, points: FloatArray) -> Area:
        """The area of faces as `outer_faces` gives them; raises InputError for normals that cancel at a node."""
        # The corners of a face are its first four nodes, or three where the fourth is a midside node or missing.
        quadrilateral = (faces[:, 3] >= 0) & (faces[:, 4] < 0)
        corners = np.where(quadrilateral[:, None], faces[:, :4], faces[:, [0, 1, 2, 0]])
        x = points[corners]
        vectors = 0.5 * np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])
        sizes = np.linalg.norm(vectors, axis=1)
        used = faces >= 0
        normals = np.zeros_like(points)
        np.add.at(normals, faces[used], np.repeat(vectors, used.sum(axis=1), axis=0))
        nodes = np.unique(faces[used])
        length = np.linalg.norm(normals[nodes], axis=1)
        if len(nodes) and length.min() <= CANCELLED * length.max():
            raise InputError(
                f"its region is pinched to a point or an edge at node {nodes[length.argmin()]}; add cells around it"
            )
        normals = normals[nodes] / length[:, None]
        middles = np.where(quadrilateral[:, None], x.mean(axis=1), x[:, :3].mean(axis=1))
        return cls(nodes, normals, vectors.sum(axis=0), sizes @ middles / max(float(sizes.sum()), np.finfo(float).tiny))


def outer_faces(cells: list[tuple[ReferenceElement, IntArray]]) -> IntArray:
    """Faces (f, 6) that belong to one of the cells (e, a) only: corners outward, then midside nodes, then -1."""
    faces, keys = [], []
    for element, connectivity in cells:
        for corners in element.faces:
            nodes = connectivity[:, _nodes_on_face(element, corners)]
            faces.append(_padded(nodes, NODES_PER_FACE))
            keys.append(_padded(np.sort(nodes[:, : len(corners)], axis=1), 4))
    _, first, count = np.unique(np.concatenate(keys), axis=0, return_index=True, return_counts=True)
    return np.concatenate(faces)[np.sort(first[count == 1])]


def _nodes_on_face(element: ReferenceElement, corners: tuple[int, ...]) -> list[int]:
    """Local nodes of a face: its corners, then the midside nodes between them."""
    places = np.asarray(element.nodes, dtype=np.float64)
    middles = [0.5 * (places[a] + places[b]) for a, b in itertools.combinations(corners, 2)]
    inner = range(element.corners, len(places))
    return [*corners, *(i for i in inner if any(np.allclose(places[i], middle) for middle in middles))]


def _padded(numbers: IntArray, width: int) -> IntArray:
    return np.pad(numbers, ((0, 0), (0, width - numbers.shape[1])), constant_values=-1)
