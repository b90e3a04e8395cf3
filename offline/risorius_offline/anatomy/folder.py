"""Import of a folder: a volume mesh with node flags, muscles.json and bone surfaces; docs/import.md has the format."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

import meshio
import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from risorius.errors import InputError
from risorius.jaw import FloatArray, JawMotion
from risorius_offline.anatomy.anatomy import Anatomy, Surface
from risorius_offline.anatomy.frame import Frame, check_size, parse_frame
from risorius_offline.anatomy.landmarks import jaw_motion, sellion
from risorius_offline.anatomy.muscle_file import read_muscle_file
from risorius_offline.anatomy.surface import as_triangles, boundary_faces, visible_faces
from risorius_offline.discretisation import CellBlock, Discretisation, IntegratedBlock
from risorius_offline.elements import ELEMENTS
from risorius_offline.muscles.assembly import dead_loads, fibre_points
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.polyline_fibres import PolylineFibres
from risorius_offline.muscles.region import Region
from risorius_offline.muscles.spline_fibres import SplineFibres

MESH_SUFFIXES = (".vtu", ".vtk", ".msh", ".inp", ".xdmf")
SURFACE_SUFFIXES = (".ply", ".stl", ".obj")
SKULL_FLAG, JAW_FLAG = "fixed_to_skull", "fixed_to_jaw"
FREE_PREFIX = "free_"
RIM_FLAG = "outer_edge"
JAW_BONE = "jaw"
EPIDERMIS = 1e-4  # metres; facial epidermis is about 0.1 mm thick


def import_folder(folder: Path) -> Anatomy:
    """Anatomy of an import folder; raises InputError that names the file, the item and the remedy."""
    mesh_path = _only_mesh(folder)
    muscle_file = read_muscle_file(folder / "muscles.json")
    frame = parse_frame(muscle_file.frame, muscle_file.units, "muscles.json")
    mesh = _read(mesh_path)
    points = frame.to_ours(mesh.points)
    if not np.isfinite(points).all():
        raise InputError(
            f"{mesh_path.name}: node {int(np.argwhere(~np.isfinite(points))[0, 0])} is not finite; mend it"
        )
    check_size(points, muscle_file.units, mesh_path.name)
    cells = _cells(mesh, mesh_path, points)
    _check_layers(cells, len(muscle_file.layer_materials), mesh_path)
    flags = {name: np.asarray(values).ravel() != 0 for name, values in mesh.point_data.items()}
    skull = _flag(flags, SKULL_FLAG, mesh_path)
    bones = {path.stem: _bone(path, frame) for path in sorted(folder.iterdir()) if path.suffix in SURFACE_SUFFIXES}
    jaw = _flag(flags, JAW_FLAG, mesh_path) if JAW_BONE in bones else np.zeros(len(points), dtype=bool)
    deep = skull | jaw
    for name, values in flags.items():
        deep |= values if name.startswith(FREE_PREFIX) else False
    faces = visible_faces(visible_faces(boundary_faces(cells), deep), flags.get(RIM_FLAG, np.zeros_like(deep)))
    skin = as_triangles(faces, points)
    origin = sellion(points[np.unique(skin)])
    muscles = muscle_file.muscles(frame, origin, _regions(muscle_file.region_ids, mesh, flags, mesh_path))
    _check_muscles(muscles, points - origin, cells)
    moved_bones = {name: Surface(bone.points - origin, bone.triangles) for name, bone in bones.items()}
    return Anatomy(
        name=folder.name,
        points=points - origin,
        cells=cells,
        materials=muscle_file.layer_materials,
        skull=skull & ~jaw,
        jaw=jaw,
        skin=skin,
        muscles=muscles,
        jaw_motion=_motion(moved_bones),
        epidermis=EPIDERMIS,
        bones=moved_bones,
        provenance={"source": folder.name, "mesh": mesh_path.name, "mesh_sha256": _sha256(mesh_path),
                    "muscles_sha256": _sha256(folder / "muscles.json")},
    )  # fmt: skip


def _only_mesh(folder: Path) -> Path:
    found = [path for path in sorted(folder.iterdir()) if path.suffix in MESH_SUFFIXES]
    if len(found) != 1:
        raise InputError(
            f"{folder}: {len(found)} volume meshes found ({', '.join(p.name for p in found) or 'none'}); "
            f"put exactly one file there, ending in {', '.join(MESH_SUFFIXES)}"
        )
    return found[0]


def _read(path: Path) -> meshio.Mesh:
    try:
        return meshio.read(path)
    except (Exception, SystemExit) as error:
        raise InputError(f"{path}: meshio cannot read it ({error}); export it again or use another format") from error


def _cells(mesh: meshio.Mesh, path: Path, points: FloatArray) -> tuple[CellBlock, ...]:
    """Volume cells by type, with their layer (cell data `layer`, 0 when absent), checked for inverted cells."""
    layers = mesh.cell_data.get("layer", [np.zeros(len(block.data), dtype=np.int64) for block in mesh.cells])
    parts: dict[str, list[tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]]] = {}
    for block, layer in zip(mesh.cells, layers, strict=True):
        if block.type in ELEMENTS:
            parts.setdefault(block.type, []).append((block.data.astype(np.int64), np.asarray(layer, dtype=np.int64)))
    if not parts:
        found = ", ".join(sorted({block.type for block in mesh.cells})) or "none"
        raise InputError(f"{path.name}: cells of type {found}; give volume cells: {', '.join(ELEMENTS)}")
    blocks = [CellBlock(kind, *map(np.concatenate, zip(*items, strict=True))) for kind, items in parts.items()]
    for cells in blocks:
        try:
            IntegratedBlock.of(points, cells)
        except InputError as error:
            raise InputError(f"{path.name}: {error}") from error
    return tuple(blocks)


def _check_layers(cells: tuple[CellBlock, ...], materials: int, path: Path) -> None:
    """Raise InputError for a layer number without a material."""
    for block in cells:
        if block.layer.min() < 0 or block.layer.max() >= materials:
            raise InputError(
                f"{path.name}: cell data 'layer' runs from {block.layer.min()} to {block.layer.max()}, "
                f"muscles.json has {materials} material(s); number layers from 0 and give each a material"
            )


def _flag(flags: dict[str, npt.NDArray[np.bool_]], name: str, path: Path) -> npt.NDArray[np.bool_]:
    if name not in flags or not flags[name].any():
        what = "is empty" if name in flags else "is missing"
        raise InputError(
            f"{path.name}: node flag {name!r} {what} (point data found: {', '.join(sorted(flags)) or 'none'}); "
            "add it as 0/1 point data"
        )
    return flags[name]


def _bone(path: Path, frame: Frame) -> Surface:
    mesh = _read(path)
    triangles = mesh.cells_dict.get("triangle")
    if triangles is None:
        raise InputError(f"{path.name}: no triangles; export the bone as a triangulated surface")
    return Surface(frame.to_ours(mesh.points), triangles.astype(np.int64))


def _motion(bones: dict[str, Surface]) -> JawMotion | None:
    if JAW_BONE not in bones:
        return None
    return jaw_motion(bones[JAW_BONE].points)


def _regions(
    ids: Sequence[str], mesh: meshio.Mesh, flags: dict[str, npt.NDArray[np.bool_]], path: Path
) -> dict[str, Region]:
    """Regions of the muscles that the mesh marks: cell data `muscle_ID`, point data `origin_ID`, `insertion_ID`."""
    result = {}
    for name in ids:
        marks = mesh.cell_data.get(f"muscle_{name}")
        if marks is None:
            raise InputError(
                f"{path.name}: cell data 'muscle_{name}' is missing "
                f"(cell data found: {', '.join(sorted(mesh.cell_data)) or 'none'}); "
                "add it as 0/1 cell data"
            )
        parts: dict[str, list[npt.NDArray[np.bool_]]] = {}
        for block, mark in zip(mesh.cells, marks, strict=True):
            parts.setdefault(block.type, []).append(np.asarray(mark).ravel() != 0)
        cells = {kind: np.flatnonzero(np.concatenate(parts[kind])) for kind in ELEMENTS if kind in parts}
        origin, insertion = (np.flatnonzero(_flag(flags, f"{area}_{name}", path)) for area in ("origin", "insertion"))
        result[name] = Region(cells, origin, insertion)
    return result


def _check_muscles(muscles: tuple[Muscle, ...], points: FloatArray, cells: tuple[CellBlock, ...]) -> None:
    """Raise InputError for a fibre line that strays from the mesh nodes (n, 3) and for a muscle without tissue."""
    tree = cKDTree(points)
    for muscle in muscles:
        if not isinstance(muscle.fibres, PolylineFibres | SplineFibres):
            continue
        for number, line in enumerate(muscle.fibres.lines):
            distance, _ = tree.query(line)
            if distance.max() > 2.0 * muscle.fibres.radius:
                raise InputError(
                    f"muscles.json: muscle {muscle.name!r}, line {number}, point {int(distance.argmax())} lies "
                    f"{1e3 * distance.max():.0f} mm outside the mesh; check its coordinates, units and frame"
                )
    discretisation = Discretisation(points, cells)
    try:
        fibre_points(discretisation, muscles)
        dead_loads(discretisation, muscles)
    except InputError as error:
        raise InputError(f"muscles.json: {error}") from error


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
