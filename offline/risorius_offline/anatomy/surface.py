"""Boundary of a mesh and the visible skin."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from risorius.jaw import FloatArray
from risorius_offline.discretisation import CellBlock, IntArray


def boundary_faces(cells: Sequence[CellBlock]) -> list[IntArray]:
    """Faces that belong to one cell only: arrays (k, 3) of triangles and (k, 4) of quadrilaterals, outward."""
    faces: dict[int, list[IntArray]] = {3: [], 4: []}
    for block in cells:
        for face in block.element.faces:
            faces[len(face)].append(block.connectivity[:, face])
    result = []
    for size, groups in faces.items():
        if groups:
            all_faces = np.concatenate(groups)
            key = np.sort(all_faces, axis=1)
            _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
            result.append(all_faces[np.sort(first[count == 1])].reshape(-1, size))
    return result


def as_triangles(faces: Sequence[IntArray], points: FloatArray) -> IntArray:
    """Triangles (m, 3) of faces; a quadrilateral is cut along its shorter diagonal."""
    triangles = [face for face in faces if face.shape[1] == 3]
    for quads in (face for face in faces if face.shape[1] == 4):
        across = np.linalg.norm(points[quads[:, 0]] - points[quads[:, 2]], axis=1)
        along = np.linalg.norm(points[quads[:, 1]] - points[quads[:, 3]], axis=1)
        turned = np.where((across <= along)[:, None], quads, np.roll(quads, -1, axis=1))
        triangles += [turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]]
    return np.concatenate(triangles) if triangles else np.zeros((0, 3), dtype=np.int64)


def visible_faces(faces: Sequence[IntArray], hidden: npt.NDArray[np.bool_]) -> list[IntArray]:
    """Faces that have at least one node that is not hidden; `hidden` (n,) flags nodes on the deep side."""
    return [face[~hidden[face].all(axis=1)] for face in faces]
