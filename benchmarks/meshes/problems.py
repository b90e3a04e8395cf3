"""The problems that elements are measured on: coarsest meshes of hexahedra, and what acts on them."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.interpolate import interp1d

from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy import load_source
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.discretisation import CellBlock
from risorius_offline.elements import ELEMENTS
from risorius_offline.muscles.loads import ActiveStress
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.polyline_fibres import PolylineFibres, nearest_on_polylines

NO_SKIN = np.zeros((0, 3), dtype=np.int64)
FACE = Path(os.environ.get("RISORIUS_ANATOMY_DIR", "../shared/anatomy")) / "artisynth_face"
SMILE = "zygomaticus_major"
DEPTHS = np.array([0.0, 3.0, 6.0, 10.0, 12.0])  # of the layers of the slab, mm
MUSCLE_LAYER = 1


@dataclass(frozen=True)
class Problem:
    """coarsest: mesh of hexahedra (and wedges). activations: of its muscles and the jaw. levels: how many meshes of
    linear elements, each twice as fine as the last. reference: level of the reference, which is of quadratic
    tetrahedra; those on coarser levels are measured. load: nodal forces (n, 3) in N on a mesh. held: flags (n, 3) of
    components that do not move, besides bone. numbered_alike: whether all hexahedra have the same axes, which a cut
    into wedges needs.
    """

    name: str
    coarsest: Anatomy
    activations: np.ndarray
    levels: int
    reference: int
    load: Callable[[Anatomy], np.ndarray] | None = None
    held: Callable[[Anatomy], np.ndarray] | None = None
    numbered_alike: bool = True

    def with_poisson(self, poisson: float) -> tuple[Yeoh, ...]:
        """Materials of the same shear modulus with another Poisson's ratio."""
        factor = 4.0 / 3.0 * (1.0 + poisson) / (1.0 - 2.0 * poisson)
        return tuple(replace(material, bulk=factor * material.c10) for material in self.coarsest.materials)


def cook() -> Problem:
    """Cook's membrane (Cook 1974) in plane strain at tissue stiffness, 48-44-16 mm and 12 mm thick.

    Left side fixed, front and back slide; a shear traction of 0.08 shear moduli on the right lifts it.
    """
    grid, cells = _grid(4, 4, 1)
    x, y, z = grid.T
    points = 1e-3 * np.column_stack([48.0 * x, 44.0 * x + y * (44.0 - 28.0 * x), 12.0 * z])
    material = Yeoh.neo_hookean(young=15e3, poisson=0.45)
    anatomy = _anatomy("cook", points, cells, np.zeros(len(cells), np.int64), (material,), x == 0.0, ())
    traction = np.array([0.0, 0.08 * 2.0 * material.c10, 0.0])

    def load(mesh: Anatomy) -> np.ndarray:
        return _traction(mesh, np.isclose(mesh.points[:, 0], 0.048), traction)

    def held(mesh: Anatomy) -> np.ndarray:
        front_or_back = np.isclose(mesh.points[:, 2], 0.0) | np.isclose(mesh.points[:, 2], 0.012)
        return front_or_back[:, None] & np.array([False, False, True])

    return Problem("cook", anatomy, np.zeros(0), levels=4, reference=3, load=load, held=held)


def slab() -> Problem:
    """A curved cheek, 40 x 40 x 12 mm, of deep tissue, muscle, fat and skin with moduli 10, 20, 3 and 60 kPa.

    One side and the deep face next to it are bone; the muscle layer pulls towards it at 5 kPa. The fibre lines are
    close enough for all points of that layer to be muscle, and no others, on every mesh.
    """
    grid, cells = _grid(4, 4, 4)
    x, y, t = 40.0 * grid[:, 0] - 20.0, 40.0 * grid[:, 1] - 20.0, DEPTHS[np.rint(4.0 * grid[:, 2]).astype(int)]
    normal = np.column_stack([x / 75.0, y / 120.0, np.ones_like(x)])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    points = 1e-3 * (np.column_stack([x, y, -(x**2) / 150.0 - y**2 / 240.0]) + t[:, None] * normal)
    bone = np.isclose(x, -20.0) | (np.isclose(t, 0.0) & (x < -9.9))
    materials = tuple(Yeoh.neo_hookean(young, 0.45) for young in (10e3, 20e3, 3e3, 60e3))
    layers = np.tile(np.arange(4), len(cells) // 4)
    middle = points.reshape(5, 5, 5, 3)[:, :, MUSCLE_LAYER : MUSCLE_LAYER + 2].mean(axis=2)
    lines = tuple(interp1d(np.linspace(0.0, 40.0, 5), middle, axis=1)(across) for across in np.arange(0.5, 40.0))
    muscle = Muscle("layer", PolylineFibres(lines, 1.585e-3), ActiveStress(10e3))
    anatomy = _anatomy("slab", points, cells, layers, materials, bone, (muscle,))
    return Problem("slab", anatomy, np.array([0.5]), levels=3, reference=2)


def face() -> Problem:
    """The published face with both zygomatici majores at one half."""
    anatomy = replace(load_source(str(FACE)), epidermis=0.0, skin=NO_SKIN)
    smiling = [0.5 * muscle.name.startswith(SMILE) for muscle in anatomy.muscles]
    return Problem("face", anatomy, np.array([*smiling, 0.0, 0.0, 0.0]), levels=2, reference=0, numbered_alike=False)


def cheek() -> Problem:
    """The published face within 35 mm of the left zygomaticus major, held where it is cut: a finer reference fits."""
    anatomy = face().coarsest
    (muscle,) = (muscle for muscle in anatomy.muscles if muscle.name == f"{SMILE}_L")
    near = [nearest_on_polylines(anatomy.points[block.connectivity].mean(axis=1), muscle.fibres.lines)[0] < 0.035
            for block in anatomy.cells]  # fmt: skip
    kept, cut = (
        [CellBlock(b.cell_type, b.connectivity[k], b.layer[k]) for b, k in zip(anatomy.cells, flags, strict=True)]
        for flags in (near, [~k for k in near])
    )
    used = np.unique(np.concatenate([block.connectivity.ravel() for block in kept]))
    number = np.full(len(anatomy.points), -1)
    number[used] = np.arange(len(used))
    held = anatomy.skull | anatomy.jaw
    held[np.concatenate([block.connectivity.ravel() for block in cut])] = True
    cheek = replace(
        anatomy,
        name="cheek",
        points=anatomy.points[used],
        cells=tuple(CellBlock(b.cell_type, number[b.connectivity], b.layer) for b in kept if len(b.layer)),
        skull=held[used],
        jaw=np.zeros(len(used), dtype=bool),
        muscles=(muscle,),
        jaw_motion=None,
    )
    return Problem("cheek", cheek, np.array([0.5]), levels=2, reference=1, numbered_alike=False)


PROBLEMS = {"cook": cook, "slab": slab, "cheek": cheek, "face": face}


def _grid(*cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 3) of the unit cube, last axis fastest, and its hexahedra (e, 8)."""
    axes = [np.linspace(0.0, 1.0, count + 1) for count in cells]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    first = np.stack(np.meshgrid(*map(np.arange, cells), indexing="ij"), axis=-1).reshape(-1, 1, 3)
    corners = np.array(ELEMENTS["hexahedron"].nodes)
    return points, np.ravel_multi_index(np.moveaxis(first + corners, -1, 0), np.array(cells) + 1)


def _anatomy(name, points, cells, layers, materials, bone, muscles) -> Anatomy:  # type: ignore[no-untyped-def]
    nothing = np.zeros(len(points), dtype=bool)
    block = CellBlock("hexahedron", cells, layers)
    return Anatomy(name, points, (block,), materials, bone, nothing, NO_SKIN, muscles, jaw_motion=None)


def _traction(mesh: Anatomy, on_face: np.ndarray, traction: np.ndarray) -> np.ndarray:
    """Nodal forces (n, 3) of a constant traction (Pa) on the flat faces whose nodes (n,) are flagged."""
    forces = np.zeros_like(mesh.points)
    for block in mesh.cells:
        for face in block.element.faces:
            loaded = block.connectivity[on_face[block.connectivity[:, face]].all(axis=1)]
            x = mesh.points[loaded[:, face]]
            area = 0.5 * np.linalg.norm(np.cross(x[:, 2] - x[:, 0], x[:, -1] - x[:, 1]), axis=1)
            nodes = loaded[:, _carriers(block, face)]
            np.add.at(forces, nodes, area[:, None, None] / nodes.shape[1] * traction)
    return forces


def _carriers(block: CellBlock, face: tuple[int, ...]) -> list[int]:
    """Nodes that share a constant traction evenly: those of the edges where there are any, else the corners."""
    if block.cell_type != "tetra10":
        return list(face)
    nodes = np.array(block.element.nodes)
    middles = [0.5 * (nodes[a] + nodes[b]) for a, b in zip(face, np.roll(face, 1), strict=True)]
    return [int(np.abs(nodes - middle).sum(axis=1).argmin()) for middle in middles]
