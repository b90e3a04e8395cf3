"""Small anatomies that are hard to solve: layered slabs with muscles, crushed cells, dragged and touching blocks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from risorius.jaw import JawMotion
from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy.anatomy import Anatomy, Surface
from risorius_offline.anatomy.surface import as_triangles, boundary_faces
from risorius_offline.discretisation import CellBlock
from risorius_offline.muscles.ellipse import Ellipse
from risorius_offline.muscles.loads import ActiveStress, ForceDensity
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.polyline_fibres import PolylineFibres
from risorius_offline.muscles.ring_fibres import RingFibres
from tests.offline.meshes import box, box_hexahedra, with_midpoints

TISSUE = Yeoh.neo_hookean(15e3, 0.45)
SIDE = 0.03  # of a slab, metres
THICKNESSES = (5e-3, 4e-3, 4e-3, 2e-3)  # deep, muscle, fat, skin; metres
YOUNGS = (10e3, 15e3, 3e3, 40e3)  # pascals
MIDDLE = 7e-3  # height of the middle of the muscle layer, metres
STRESS, SHEET_STRESS = 20e3, 300e3  # pascals

# Corners of every element and the corners at the other ends of their three edges, so that volumes are positive.
CORNERS = {
    "hexahedron": [
        (0, 1, 3, 4), (1, 2, 0, 5), (2, 3, 1, 6), (3, 0, 2, 7),
        (4, 7, 5, 0), (5, 4, 6, 1), (6, 5, 7, 2), (7, 6, 4, 3),
    ],
    "wedge": [(0, 1, 2, 3), (1, 2, 0, 4), (2, 0, 1, 5), (3, 5, 4, 0), (4, 3, 5, 1), (5, 4, 3, 2)],
    "tetra": [(0, 1, 2, 3)],
}  # fmt: skip


def line(start: Sequence[float], end: Sequence[float]) -> np.ndarray:
    return np.array([start, end])


def pull(name: str, *lines: np.ndarray, radius: float = 4e-3, stress: float = STRESS) -> Muscle:
    return Muscle(name, PolylineFibres(lines, radius), ActiveStress(stress))


ALONG = pull("along", line((0.005, 0.015, MIDDLE), (0.025, 0.015, MIDDLE)))
ACROSS = pull("across", line((0.015, 0.005, MIDDLE), (0.015, 0.025, MIDDLE)))
LEFT = pull("left", line((0.0, 0.015, MIDDLE), (0.013, 0.015, MIDDLE)))
RIGHT = pull("right", line((0.030, 0.015, MIDDLE), (0.017, 0.015, MIDDLE)))
SHEET_LINES = (line((0.005, y, MIDDLE), (0.025, y, MIDDLE)) for y in (0.009, 0.015, 0.021))
SHEET = pull("sheet", *SHEET_LINES, stress=SHEET_STRESS)
DENSITY = Muscle("density", PolylineFibres(ALONG.fibres.lines, 4e-3), ForceDensity(STRESS / 0.02))
RING = Muscle(
    "ring",
    RingFibres(Ellipse((0.015, 0.015, MIDDLE), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.009, 0.006)), 3e-3),
    ActiveStress(STRESS),
)
MUSCLES = {"one muscle": (ALONG,), "antagonists": (LEFT, RIGHT), "crossing muscles": (ALONG, ACROSS)}


def slab(
    cell_type: str = "hexahedron",
    muscles: tuple[Muscle, ...] = (ALONG,),
    *,
    youngs: tuple[float, ...] = YOUNGS,
    poisson: float = 0.45,
    skin: float = THICKNESSES[-1],
    epidermis: float = 0.0,
) -> Anatomy:
    """A cheek of four layers, fixed beneath; fibres lie in the muscle layer. skin, epidermis: thickness in metres."""
    heights = np.cumsum([0.0, *THICKNESSES[:-1], skin])
    points, cells = box(cell_type, (4, 4, 4), (SIDE, SIDE, 4.0))
    layer = points[cells.connectivity, 2].mean(axis=1).astype(np.int64)
    points[:, 2] = np.interp(points[:, 2], np.arange(5), heights)
    block = CellBlock(cell_type, cells.connectivity, layer)
    return Anatomy(
        name="slab",
        points=points,
        cells=(block,),
        materials=tuple(Yeoh.neo_hookean(young, poisson) for young in youngs),
        skull=np.isclose(points[:, 2], 0.0),
        jaw=np.zeros(len(points), dtype=bool),
        skin=top_triangles(points, block),
        muscles=muscles,
        jaw_motion=None,
        epidermis=epidermis,
    )


def top_triangles(points: np.ndarray, block: CellBlock) -> np.ndarray:
    triangles = as_triangles(boundary_faces([block]), points)
    return triangles[np.isclose(points[triangles, 2], points[:, 2].max()).all(axis=1)]


def radius_ratios(tetrahedra: np.ndarray) -> np.ndarray:
    """3 r / R (e,) of the inscribed and the circumscribed sphere of tetrahedra (e, 4, 3); negative when inverted."""
    a, b, c = np.moveaxis(tetrahedra[:, 1:] - tetrahedra[:, :1], 1, 0)
    six_volumes = np.einsum("ei,ei->e", a, np.cross(b, c))
    faces = [np.cross(a, b), np.cross(b, c), np.cross(c, a), np.cross(b - a, c - a)]
    double_areas = sum(np.linalg.norm(face, axis=1) for face in faces)
    squares = [np.einsum("ei,ei->e", v, v)[:, None] for v in (a, b, c)]
    centre = squares[0] * np.cross(b, c) + squares[1] * np.cross(c, a) + squares[2] * np.cross(a, b)
    return 6.0 * six_volumes**2 * np.sign(six_volumes) / (double_areas * np.linalg.norm(centre, axis=1))


def smallest_ratio(points: np.ndarray, block: CellBlock) -> float:
    """Smallest radius ratio of the tetrahedra at the corners of all cells."""
    corners = block.connectivity[:, CORNERS[block.cell_type]].reshape(-1, 4)
    return float(radius_ratios(points[corners]).min())


def crushed_block(cell_type: str, ratio: float = 0.01, dragged: float = 0.0) -> Anatomy:
    """A 20 mm cube with a muscle; its middle node is moved until the smallest radius ratio is `ratio`.

    dragged: metres sideways of its top at jaw_sideways = 1.
    """
    straight = "tetra" if cell_type == "tetra10" else cell_type
    points, block = box(straight, (2, 2, 2), (0.02,) * 3)
    middle = np.linalg.norm(points - 0.01, axis=1).argmin()
    towards, low, high = np.array([0.009, 0.0095, 0.0098]), 0.0, 1.0
    for _ in range(50):
        share = 0.5 * (low + high)
        points[middle] = 0.01 + share * towards
        low, high = (share, high) if smallest_ratio(points, block) > ratio else (low, share)
    points[middle] = 0.01 + low * towards
    if cell_type == "tetra10":
        points, connectivity = with_midpoints(points, block.connectivity)
        block = CellBlock(cell_type, connectivity, block.layer)
    muscle = pull("pull", line((0.0, 0.01, 0.01), (0.02, 0.01, 0.012)), radius=6e-3)
    top = np.isclose(points[:, 2], 0.02)
    return moved_block(points, block, dragging(dragged), top & (dragged > 0.0), (muscle,))


def moved_block(
    points: np.ndarray, block: CellBlock, motion: JawMotion, jaw: np.ndarray, muscles: tuple[Muscle, ...] = ()
) -> Anatomy:
    """A block fixed at z = 0 of which the jaw nodes move."""
    return Anatomy(
        name="moved block",
        points=points,
        cells=(block,),
        materials=(TISSUE,),
        skull=np.isclose(points[:, 2], 0.0),
        jaw=jaw,
        skin=as_triangles(boundary_faces([block]), points),
        muscles=muscles,
        jaw_motion=motion,
    )


def column(cell_type: str, motion: JawMotion) -> Anatomy:
    """20 x 20 x 30 mm, fixed at its bottom, its top moved as a jaw."""
    points, block = box(cell_type, (2, 2, 4), (0.02, 0.02, 0.03), 0.1)
    return moved_block(points, block, motion, np.isclose(points[:, 2], 0.03))


def piston(cell_type: str, motion: JawMotion) -> Anatomy:
    """The column with its sides fixed as well: the mean of J is what its top leaves of the volume."""
    free = column(cell_type, motion)
    x, y = free.points[:, 0], free.points[:, 1]
    side = np.isclose(x, 0.0) | np.isclose(x, 0.02) | np.isclose(y, 0.0) | np.isclose(y, 0.02)
    return replace(free, skull=free.skull | (side & ~free.jaw))


def dragging(sideways: float = 0.0, along: float = 0.0) -> JawMotion:
    """jaw_sideways = 1 shears a column by metres, jaw_forward = 1 stretches it."""
    return JawMotion((0.0, 0.0, 0.0), 0.0, 0.0, along, sideways)


def turning(degrees: float) -> JawMotion:
    """jaw_open = 1 turns the top of a column about the axis along x through its middle."""
    return JawMotion((0.01, 0.01, 0.03), float(np.radians(degrees)), 0.0, 0.0, 0.0)


def box_surface(low: Sequence[float], high: Sequence[float]) -> Surface:
    points, cells = box_hexahedra((1, 1, 1), tuple(np.subtract(high, low)))
    block = CellBlock("hexahedron", cells, np.zeros(1, dtype=np.int64))
    return Surface(points + low, as_triangles(boundary_faces([block]), points))


def block_over_bone(down: float, muscles: tuple[Muscle, ...] = ()) -> Anatomy:
    """A cube held at its top, 0.5 mm over a bone; jaw_forward = 1 presses it down by metres."""
    points, block = box("hexahedron", (4, 4, 4), (0.02,) * 3)
    bone = box_surface((0.004, -0.01, -0.012), (0.016, 0.03, -5e-4))
    jaw = np.isclose(points[:, 2], 0.02)
    anatomy = moved_block(points, block, dragging(along=-down), jaw, muscles)
    return replace(anatomy, skull=np.zeros_like(jaw), bones={"maxilla": bone})


def two_blocks(down: float) -> Anatomy:
    """Two cubes 1 mm apart, of different meshes; jaw_forward = 1 presses the upper on the lower by metres."""
    (a, below), (b, above) = box("hexahedron", (3, 3, 2), (0.02,) * 3), box("hexahedron", (2, 2, 2), (0.02,) * 3)
    points = np.concatenate([a, b + np.array([0.0, 0.0, 0.021])])
    cells = np.concatenate([below.connectivity, len(a) + above.connectivity])
    block = CellBlock("hexahedron", cells, np.zeros(len(cells), dtype=np.int64))
    return moved_block(points, block, dragging(along=-down), np.isclose(points[:, 2], 0.041))
