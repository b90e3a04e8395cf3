"""The seed's artificial model: two nested cylinders (Figure 7.7), the inner one a muscle along the axis.

Its fibres are the test deformation (7.7), from the bottom of the inner cylinder to its top, with its hull as capsule.
The bottom is fixed, the rest of the boundary is free. The axis is y. The mesh is a square core blended into rings, with
the symmetry of a square.
"""

from __future__ import annotations

import numpy as np

from risorius.jaw import FloatArray
from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.anatomy.surface import as_triangles, boundary_faces
from risorius_offline.discretisation import CellBlock, IntArray
from risorius_offline.muscles.deformation_fibres import DeformationFibres
from risorius_offline.muscles.loads import ActiveStress
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.region import Region

HEIGHT, INNER_RADIUS, OUTER_RADIUS = 0.06, 0.010, 0.020
CORE_CELLS, INNER_RINGS, OUTER_RINGS, LAYERS = 4, 2, 4, 16
MUSCLE_STRESS = 20e3
TISSUE = Yeoh.neo_hookean(young=15e3, poisson=0.49)


def nested_cylinders() -> Anatomy:
    """Two nested cylinders, 60 mm high, with the muscle `axial`; tissue of E = 15 kPa, nu = 0.49."""
    disc, quads = _disc()
    points = _lift(disc)
    count = len(disc)
    levels = count * np.arange(LAYERS)[:, None, None]
    lower, upper = quads[None] + levels, quads[None] + levels + count
    cells = np.concatenate([lower, upper], axis=2).reshape(-1, 8)
    block = CellBlock("hexahedron", cells, np.zeros(len(cells), dtype=np.int64))
    bottom = np.isclose(points[:, 1], 0.0)
    top = np.isclose(points[:, 1], HEIGHT)
    inner = np.hypot(points[:, 0], points[:, 2]) <= INNER_RADIUS * (1.0 + 1e-9)
    muscle = Region(
        cells={block.cell_type: np.flatnonzero(inner[cells].all(axis=1))},
        origin=np.flatnonzero(inner & bottom),
        insertion=np.flatnonzero(inner & top),
    )
    return Anatomy(
        name="nested cylinders",
        points=points,
        cells=(block,),
        materials=(TISSUE,),
        skull=bottom,
        jaw=np.zeros(len(points), dtype=bool),
        skin=as_triangles(boundary_faces([block]), points),
        muscles=(Muscle("axial", DeformationFibres(muscle), ActiveStress(MUSCLE_STRESS)),),
        jaw_motion=None,
        provenance={"source": "two nested cylinders after Figure 7.7 of Gladilin's chapter 7"},
    )


def _disc() -> tuple[FloatArray, IntArray]:
    """Nodes (n, 2) and quadrilaterals (m, 4), counter-clockwise in (z, x) so that extrusion along y is positive."""
    side = np.linspace(-1.0, 1.0, CORE_CELLS + 1)
    rings = INNER_RINGS + OUTER_RINGS
    half = 0.5 * INNER_RADIUS
    core = half * np.array([(a, b) for a in side for b in side])
    n = CORE_CELLS + 1
    rim = [(i, 0) for i in range(n - 1)] + [(n - 1, j) for j in range(n - 1)]
    rim += [(i, n - 1) for i in range(n - 1, 0, -1)] + [(0, j) for j in range(n - 1, 0, -1)]
    rim_numbers = np.array([i * n + j for i, j in rim])
    square = core[rim_numbers]
    angle = np.arctan2(square[:, 1], square[:, 0])
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    nodes = [core]
    for ring in range(1, rings + 1):
        if ring <= INNER_RINGS:
            blend = ring / INNER_RINGS
            nodes.append((1.0 - blend) * square + blend * INNER_RADIUS * circle)
        else:
            nodes.append(circle * (INNER_RADIUS + (OUTER_RADIUS - INNER_RADIUS) * (ring - INNER_RINGS) / OUTER_RINGS))
    quads = [
        (i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1)
        for i in range(CORE_CELLS)
        for j in range(CORE_CELLS)
    ]
    previous = rim_numbers
    for ring in range(rings):
        current = n * n + ring * len(rim) + np.arange(len(rim))
        following = np.roll(np.arange(len(rim)), -1)
        quads += np.column_stack([previous, current, current[following], previous[following]]).tolist()
        previous = current
    return np.concatenate(nodes), np.array(quads, dtype=np.int64)


def _lift(disc: FloatArray) -> FloatArray:
    """Stack the disc, whose plane is (z, x), along y."""
    heights = np.linspace(0.0, HEIGHT, LAYERS + 1)
    layers = [np.column_stack([disc[:, 1], np.full(len(disc), y), disc[:, 0]]) for y in heights]
    return np.concatenate(layers)
