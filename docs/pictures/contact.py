"""Draws contact.png: the lips of the published face under orbicularis oris, cut along the midline, free and in contact.

python docs/pictures/contact.py ANATOMY_FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pyvista

from risorius_offline.anatomy import Anatomy, load_source
from risorius_offline.contact_choice import ContactChoice
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.equilibrium import EquilibriumSolver

MUSCLES = {"orbicularis_oris_peripheralis": 1.0, "mentalis": 0.5}
CUT = 0.0005  # metres beside the midline, so that no face of the mesh lies in the cut
VTK_CELLS = {"hexahedron": pyvista.CellType.HEXAHEDRON, "wedge": pyvista.CellType.WEDGE}
BONE_COLOURS = {"jaw": "tab:red", "maxilla": "tab:green"}


def main() -> None:
    """Solve both and draw them side by side."""
    anatomy = load_source(sys.argv[1])
    inputs = anatomy.inputs
    parameters = inputs.to_parameters(inputs.weights({}), MUSCLES)
    figure, axes = plt.subplots(1, 2, figsize=(9.0, 4.6), layout="constrained")
    for axis, contact in zip(axes, (False, True), strict=True):
        model = EffectChoice(contact=ContactChoice.FULL if contact else ContactChoice.NONE).model(anatomy)
        draw(axis, anatomy, EquilibriumSolver(model).solve(parameters).u)
        axis.set_title("with contact" if contact else "without contact")
    figure.savefig(Path(__file__).with_name("contact.png"), dpi=110)


def draw(axis: plt.Axes, anatomy: Anatomy, u: np.ndarray) -> None:
    """Draw tissue and teeth, cut beside the midline."""
    for block in anatomy.cells:
        tissue = pyvista.UnstructuredGrid({VTK_CELLS[block.cell_type]: block.connectivity}, anatomy.points + u)
        draw_cut(axis, tissue, color="tab:blue", linewidth=0.6)
    for name, colour in BONE_COLOURS.items():
        bone = anatomy.bones[name]
        draw_cut(axis, pyvista.PolyData.from_regular_faces(bone.points, bone.triangles), color=colour, linewidth=1.5)
    axis.set(aspect="equal", xlim=(-20, 22), ylim=(-95, -50), xlabel="forward, mm", ylabel="up, mm")


def draw_cut(axis: plt.Axes, mesh: pyvista.DataSet, **style: object) -> None:
    """Draw the outlines of the cells that the cut meets."""
    cut = mesh.slice(normal="x", origin=(CUT, 0.0, 0.0))
    for number in range(cut.n_cells):
        outline = 1e3 * cut.get_cell(number).points
        closed = np.vstack([outline, outline[:1]])
        axis.plot(closed[:, 2], closed[:, 1], **style)


if __name__ == "__main__":
    main()
