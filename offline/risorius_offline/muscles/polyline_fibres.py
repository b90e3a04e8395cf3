"""Fibres along given polylines: tissue near a line contracts along the line (as in the ArtiSynth face model)."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

import h5py
import numpy as np

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.discretisation import Discretisation
from risorius_offline.muscles.fibres import FibreField, InsertionEnd, volume_positions


@dataclass(frozen=True)
class PolylineFibres:
    """Tissue within `radius` metres of a line, along the nearest segment.

    lines: (k, 3) each, metres, from the origin to the insertion. The sense only matters to a force density.
    side: 1 or -1 for tissue with x of that sign alone, as of the half of a ring that ends in the midline; 0 for all.
    """

    lines: tuple[FloatArray, ...]
    radius: float
    side: int = 0
    kind: ClassVar[str] = "polylines"

    def field(self, discretisation: Discretisation) -> FibreField:
        """Points within the radius; raises InputError where there are none."""
        positions = volume_positions(discretisation)
        distance, tangent = nearest_on_polylines(positions, self.lines)
        inside = np.flatnonzero((distance <= self.radius) & (self.side * positions[:, 0] >= 0.0))
        if not len(inside):
            raise InputError(no_tissue(self.radius))
        return FibreField(inside, -tangent[inside])

    def length(self, discretisation: Discretisation) -> float:
        """Mean length of the lines, metres."""
        return mean_length(self.lines)

    def insertion_end(self, discretisation: Discretisation) -> InsertionEnd:
        """Mean of the last points and of the last tangents of the lines."""
        ends = np.array([line[-1] for line in self.lines])
        return mean_end(ends, np.array([line[-1] - line[-2] for line in self.lines]), self.radius)

    def write(self, group: h5py.Group) -> None:
        """Store lines, radius and side."""
        group.attrs["radius"] = self.radius
        group.attrs["side"] = self.side
        for number, line in enumerate(self.lines):
            group[f"{number:03d}"] = line

    @classmethod
    def read(cls, group: h5py.Group) -> PolylineFibres:
        """Load what `write` stored."""
        lines = tuple(line[()] for line in group.values())
        return cls(lines, float(group.attrs["radius"]), int(group.attrs.get("side", 0)))


def no_tissue(radius: float) -> str:
    """Message for lines without tissue near them; radius in metres."""
    return (
        f"no tissue within its radius of {1e3 * radius:g} mm; check its coordinates, its units or give a larger radius"
    )


def mean_length(lines: Iterable[FloatArray]) -> float:
    """Mean length of polylines (k, 3), in their unit."""
    return float(np.mean([np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in lines]))


def mean_end(ends: FloatArray, tangents: FloatArray, radius: float) -> InsertionEnd:
    """One end for lines that end at (k, 3) with tangents (k, 3) of any length."""
    direction = (tangents / np.linalg.norm(tangents, axis=1, keepdims=True)).sum(axis=0)
    return InsertionEnd(ends.mean(axis=0), direction / np.linalg.norm(direction), radius)


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
