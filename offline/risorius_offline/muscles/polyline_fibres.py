"""Fibres along given polylines: tissue near a line contracts along the line (as in the ArtiSynth face model)."""

from __future__ import annotations

import itertools

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray


def nearest_on_polylines(points: FloatArray, polylines: tuple[FloatArray, ...]) -> tuple[FloatArray, FloatArray]:
    """Distance (n,) from points (n, 3) to the nearest segment of the polylines, and its unit tangent (n, 3).

    Where several segments of one polyline meet, the tangent of the nearest wins; ties go to the first.
    """
    best = np.full(len(points), np.inf)
    tangent = np.zeros((len(points), 3))
    for line in polylines:
        for start, end in itertools.pairwise(line):
            edge = end - start
            length = float(np.linalg.norm(edge))
            if length == 0.0:
                continue
            along = np.clip((points - start) @ edge / length**2, 0.0, 1.0)
            distance = np.linalg.norm(points - start - along[:, None] * edge, axis=1)
            closer = distance < best
            best[closer] = distance[closer]
            tangent[closer] = edge / length
    return best, tangent


def fibre_points(
    positions: FloatArray, polylines: tuple[FloatArray, ...], radius: float
) -> tuple[IntArray, FloatArray]:
    """Numbers (k,) of the positions (n, 3) within `radius` metres of a line, and the fibre directions (k, 3) there."""
    distance, tangent = nearest_on_polylines(positions, polylines)
    inside = np.flatnonzero(distance <= radius)
    return inside, tangent[inside]
