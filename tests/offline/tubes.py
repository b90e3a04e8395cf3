"""Tubes for tests of fibres: straight bars and bent ones, with origin and insertion at their ends."""

from __future__ import annotations

import numpy as np

from risorius_offline.discretisation import CellBlock, Discretisation
from risorius_offline.muscles.region import Region
from tests.offline.meshes import box, box_hexahedra


def bar(cell_type, size=(0.03, 0.008, 0.006), cells=(6, 2, 2), distortion=0.2):
    """A bar along x as a muscle: origin at x = 0, insertion at its other end."""
    points, block = box(cell_type, cells, size, distortion)
    origin, insertion = (np.flatnonzero(np.isclose(points[:, 0], x)) for x in (0.0, size[0]))
    return Discretisation(points, [block]), Region({cell_type: np.arange(len(block.connectivity))}, origin, insertion)


def bent_tube(bend_radius, tube_radius=0.004, across=4, along=16):
    """A quarter of a torus about z, of hexahedra; from the origin at y = 0 to the insertion at x = 0."""
    square, hexahedra = box_hexahedra((across, across, along), (2.0, 2.0, 1.0))
    u, v, angle = square[:, 0] - 1.0, square[:, 1] - 1.0, 0.5 * np.pi * square[:, 2]
    rho = bend_radius + tube_radius * u * np.sqrt(1.0 - 0.5 * v**2)
    points = np.column_stack([rho * np.cos(angle), rho * np.sin(angle), -tube_radius * v * np.sqrt(1.0 - 0.5 * u**2)])
    block = CellBlock("hexahedron", hexahedra, np.zeros(len(hexahedra), dtype=np.int64))
    ends = (np.flatnonzero(np.isclose(angle, end)) for end in (0.0, 0.5 * np.pi))
    return Discretisation(points, [block]), Region({"hexahedron": np.arange(len(hexahedra))}, *ends)


def angles(directions, expected):
    """Degrees (k,) between unit vectors."""
    return np.degrees(2.0 * np.arcsin(np.clip(0.5 * np.linalg.norm(directions - expected, axis=1), 0.0, 1.0)))
