"""Contact sheets of the built-in head from the full model, every face an equilibrium of its own.

    python docs/pictures/head_sheets.py SIZE FOLDER [SHEET ...]

Writes FOLDER/expressions.png, head_units.png, head_jaw.png and head_muscles.png, or those of the sheets named.
"""

from __future__ import annotations

import sys
from pathlib import Path

from risorius.companion import Companion, posed_companions
from risorius.contact_sheet import VIEWS, arrange
from risorius.jaw import FloatArray
from risorius.picture import draw_faces, save_png
from risorius.sheets import SHEETS, Face, faces_of
from risorius_offline.contact_choice import ContactChoice
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.equilibrium import EquilibriumSolver, NotConvergedError
from risorius_offline.head import built_in_head

PICTURE = (280, 320)
NAMES = {"expressions": "expressions.png"} | {sheet: f"head_{sheet}.png" for sheet in ("units", "jaw", "muscles")}


class Head:
    """A head that takes the faces of a sheet."""

    def __init__(self, size: str) -> None:
        self.anatomy = built_in_head(size)
        self._solver = EquilibriumSolver(EffectChoice(ContactChoice.LIPS).model(self.anatomy))

    def parameters(self, face: Face) -> FloatArray:
        """Muscle activations and pose weights (p,) of a face."""
        table = self.anatomy.inputs
        return table.to_parameters(table.weights(face.weights), face.muscles)

    def vertices(self, parameters: FloatArray) -> FloatArray:
        """Visible points (v, 3) in equilibrium, metres."""
        surface = self.anatomy.visible_surface
        moved: FloatArray = surface.points + surface.weights @ self._solver.solve(parameters).u
        return moved

    def companions(self, parameters: FloatArray) -> list[Companion]:
        """Companions where the poses put them."""
        poses = self.anatomy.poses
        return posed_companions(
            self.anatomy.companions, poses, poses.lift_coordinates(parameters[len(self.anatomy.muscles) :])
        )


def draw(head: Head, sheet: str, path: Path) -> None:
    """Write one sheet; a face without an equilibrium is left out and named."""
    labels, shown, beside = [], [], []
    for face in faces_of(sheet, head.anatomy.inputs):
        parameters = head.parameters(face)
        try:
            shown.append(head.vertices(parameters))
        except NotConvergedError as error:
            print(f"{face.label}: {error}", flush=True)
            continue
        labels.append(face.label)
        beside.append(head.companions(parameters))
        print(f"{sheet}: {face.label}", flush=True)
    surface = head.anatomy.visible_surface
    pictures = draw_faces(
        shown, surface.triangles, views=VIEWS, size=PICTURE, colours=surface.colours, companions=beside
    )
    save_png(path, arrange(pictures, labels))


def main() -> None:
    """Draw the sheets named on the command line, all by default."""
    size, folder, *sheets = sys.argv[1:]
    head = Head(size)
    for sheet in sheets or SHEETS:
        draw(head, sheet, Path(folder) / NAMES[sheet])


if __name__ == "__main__":
    main()
