"""Draws docs/pictures/muscles.png: `python docs/pictures/muscles.py`, with the extras offline and view."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyvista
from PIL import Image

from risorius_offline.anatomy.nested_cylinders import nested_cylinders
from risorius_offline.discretisation import CellBlock, Discretisation
from risorius_offline.muscles.deformation_fibres import DeformationFibres
from risorius_offline.muscles.ellipse import Ellipse
from risorius_offline.muscles.fibres import FibreField, InsertionEnd, volume_positions
from risorius_offline.muscles.insertion_cone import TABLE_7_3
from risorius_offline.muscles.laplace_fibres import LaplaceFibres
from risorius_offline.muscles.radial_fibres import RadialFibres
from risorius_offline.muscles.region import Region
from risorius_offline.muscles.ring_fibres import RingFibres
from risorius_offline.muscles.spline_fibres import SplineFibres

MUSCLE, BACKGROUND = "#b03a2e", "white"
HALF_SLICE = 1.5e-3  # metres
COLOURS = 32  # of the palette, for a small file
Panel = tuple[Discretisation, FibreField, str]


def lattice(cells: tuple[int, int, int], size: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 3) of a box from the origin and its hexahedra (e, 8)."""
    axes = [np.linspace(0.0, length, count + 1) for length, count in zip(size, cells, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    corners = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
    first = np.stack(np.meshgrid(*[np.arange(c) for c in cells], indexing="ij"), axis=-1).reshape(-1, 1, 3)
    return points, np.ravel_multi_index(np.moveaxis(first + corners, -1, 0), np.array(cells) + 1)


def meshed(points: np.ndarray, hexahedra: np.ndarray) -> Discretisation:
    """A mesh of hexahedra."""
    return Discretisation(points, [CellBlock("hexahedron", hexahedra, np.zeros(len(hexahedra), dtype=np.int64))])


def fan() -> Panel:
    """A bent muscle that widens towards its insertion."""
    square, hexahedra = lattice((5, 3, 20), (2.0, 2.0, 1.0))
    angle, widening = 0.4 * np.pi * square[:, 2], 0.003 + 0.007 * square[:, 2] ** 2
    rho = 0.04 + widening * (square[:, 0] - 1.0)
    points = np.column_stack([rho * np.cos(angle), rho * np.sin(angle), -0.003 * (square[:, 1] - 1.0)])
    ends = (np.flatnonzero(np.isclose(square[:, 2], end)) for end in (0.0, 1.0))
    mesh = meshed(points, hexahedra)
    region = Region({"hexahedron": np.arange(len(hexahedra))}, *ends)
    return mesh, LaplaceFibres(region).field(mesh), "Laplace problem (7.6)"


def cylinders() -> Panel:
    """The seed's artificial model."""
    anatomy = nested_cylinders()
    mesh = Discretisation(anatomy.points, anatomy.cells)
    field = DeformationFibres(anatomy.muscles[0].fibres.region).field(mesh)
    return mesh, field, "test deformation (7.7)"


def plate() -> Discretisation:
    """Tissue for the constructions that need no region."""
    return meshed(*lattice((24, 18, 3), (0.06, 0.045, 0.006)))


def panels() -> list[Panel]:
    """Mesh, fibres and title of each picture."""
    mesh = plate()
    line = np.array([[0.005, 0.005, 0.003], [0.02, 0.03, 0.003], [0.035, 0.032, 0.003], [0.055, 0.015, 0.003]])
    lips = Ellipse((0.03, 0.0225, 0.003), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.02, 0.012))
    end = InsertionEnd(np.array([0.01, 0.0225, 0.003]), np.array([1.0, 0.0, 0.0]), 0.002)
    cone = TABLE_7_3["zygomaticus_major"].field(mesh, end)
    return [
        cylinders(),
        fan(),
        (mesh, SplineFibres((line,), 0.003, 0.006).field(mesh), "B-spline, radius 3 to 6 mm"),
        (mesh, RingFibres(lips, 0.005).field(mesh), "ring"),
        (mesh, RadialFibres(lips, 0.005).field(mesh), "radial ellipse (Figure 7.10)"),
        (mesh, cone, "insertion cone (Figure 7.6)"),
    ]


def draw(plotter: pyvista.Plotter, mesh: Discretisation, field: FibreField, title: str) -> None:
    """One panel: arrows to where the muscle pulls, at the points near the middle plane z = const."""
    positions = volume_positions(mesh)[field.points]
    shown = np.abs(positions[:, 2] - mesh.points[:, 2].mean()) < HALF_SLICE
    plotter.add_text(title, font_size=11, color="black", position="upper_edge")
    cells = mesh.volumes[0].cells.connectivity
    grid = pyvista.UnstructuredGrid({pyvista.CellType.HEXAHEDRON: cells}, mesh.points)
    surface = grid.extract_surface(algorithm=None)
    plotter.add_mesh(surface, color="grey", opacity=0.08, lighting=False)
    plotter.add_mesh(surface.extract_feature_edges(40.0), color="grey", line_width=1, lighting=False)
    cloud = pyvista.PolyData(positions[shown])
    cloud["direction"] = field.directions[shown]
    arrow = pyvista.Arrow(tip_length=0.35, tip_radius=0.12, shaft_radius=0.035)
    plotter.add_mesh(
        cloud.glyph(orient="direction", scale=False, factor=0.0022, geom=arrow), color=MUSCLE, lighting=False
    )


def main() -> None:
    """Write the picture."""
    plotter = pyvista.Plotter(shape=(2, 3), off_screen=True, window_size=(1200, 720), border=False)
    plotter.set_background(BACKGROUND)
    for number, panel in enumerate(panels()):
        plotter.subplot(*divmod(number, 3))
        draw(plotter, *panel)
        plotter.view_vector((0.0, 0.25 if number == 0 else 0.0, 1.0), (0.0, 1.0, 0.0))
        plotter.enable_parallel_projection()
    picture = Image.fromarray(plotter.screenshot(return_img=True))
    picture.quantize(COLOURS).save(Path(__file__).with_suffix(".png"), optimize=True)


if __name__ == "__main__":
    main()
