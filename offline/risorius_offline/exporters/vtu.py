"""VTU files for ParaView and other programs that build on VTK: the tissue at an equilibrium, and its skin.

Points are those at rest; warping by `displacement_m` gives the deformed shape. SI units; names say which.
"""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np

from risorius import storage
from risorius.jaw import FloatArray
from risorius_offline.discretisation import CellBlock, IntArray
from risorius_offline.equilibrium import Equilibrium
from risorius_offline.full_model import FullModel
from risorius_offline.quantities.skin import SkinState

# In VTK the first triangle of a wedge faces outwards; in ours, as in Gmsh and Abaqus, the second does.
VTK_ORDER = {"wedge": [3, 4, 5, 0, 1, 2]}


def write_tissue(path: Path, model: FullModel, equilibrium: Equilibrium) -> None:
    """Write all cells with displacement, bones, layer, mean and smallest J and active stress.

    The active stress is the sum of a T over the muscles, the mean over the cell.
    """
    u, anatomy, blocks = equilibrium.u, model.anatomy, model.discretisation.volumes
    mesh = meshio.Mesh(
        anatomy.points,
        [(block.cells.cell_type, _vtk_connectivity(block.cells)) for block in blocks],
        point_data={
            "displacement_m": u,
            "fixed_to_skull": anatomy.skull.astype(np.uint8),
            "fixed_to_jaw": anatomy.jaw.astype(np.uint8),
        },
        cell_data={
            "layer": [block.cells.layer for block in blocks],
            "J_mean": [block.mean_jacobians(u) for block in blocks],
            "J_smallest": [np.linalg.det(block.deformation_gradients(u)).min(axis=1) for block in blocks],
            "active_stress_Pa": _active_stresses(model, equilibrium.parameters),
        },
    )
    _write(path, mesh)


def write_skin(path: Path, model: FullModel, u: FloatArray, skin: SkinState) -> None:
    """Write the skin triangles with their state and, at the vertices, displacement and the means of the scalars."""
    scalars = {
        "stretch_1": skin.stretches[:, 0],
        "stretch_2": skin.stretches[:, 1],
        "strain_1": skin.strains[:, 0],
        "strain_2": skin.strains[:, 1],
        "area_ratio": skin.area_ratios,
        **{f"stress_{k + 1}_Pa": skin.principal_stresses[:, k] for k in range(3)},
        "von_mises_Pa": skin.von_mises,
    }
    vectors = {"direction_1": skin.directions[:, 0], "direction_2": skin.directions[:, 1]}
    mesh = meshio.Mesh(
        model.anatomy.points[skin.vertices],
        [("triangle", np.searchsorted(skin.vertices, skin.triangles))],
        point_data={
            "displacement_m": u[skin.vertices],
            **{name: skin.at_vertices(values) for name, values in scalars.items()},
        },
        cell_data={name: [values] for name, values in (scalars | vectors).items()},
    )
    _write(path, mesh)


def _vtk_connectivity(cells: CellBlock) -> IntArray:
    order = VTK_ORDER.get(cells.cell_type)
    return cells.connectivity[:, order] if order else cells.connectivity


def _active_stresses(model: FullModel, parameters: FloatArray) -> list[FloatArray]:
    """Per block (e,): sum over the muscles of a T, the mean over the cell."""
    activations = parameters[: model.muscle_count]
    return [
        np.bincount(
            listed.element,
            weights=activations[listed.muscle] * listed.stress * block.weights[listed.element, listed.point],
            minlength=len(block.weights),
        )
        / block.weights.sum(axis=1)
        for block, listed in zip(model.discretisation.volumes, model.fibres.points, strict=True)
    ]


def _write(path: Path, mesh: meshio.Mesh) -> None:
    with storage.replaced_when_complete(path) as partial:
        mesh.write(partial, file_format="vtu")
