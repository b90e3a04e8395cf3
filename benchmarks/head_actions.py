"""Single actions of the built-in head at full weight beside published motion: the table of docs/head.md.

    python benchmarks/head_actions.py [SIZE]

Contact with teeth, bones and eyeballs is on. Motion is that of the visible surface, in millimetres: out (to the
person's left), up, forward, of points on the left side.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from risorius.jaw import FloatArray
from risorius_offline.anatomy import Anatomy
from risorius_offline.contact_choice import ContactChoice
from risorius_offline.discretisation import IntArray
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.head import built_in_head
from risorius_offline.head.openings import LIP_LINE
from risorius_offline.head.proportions import ADULT
from risorius_offline.head.reshape import SELLION
from risorius_offline.head.skull import INCISAL_EDGE
from risorius_offline.head.warp import Warp

PLACES = {
    "corner of the mouth": LIP_LINE[-1],
    "inner brow": (12.0, 36.0, 93.0),
    "middle of the brow": (28.0, 38.0, 87.0),
    "upper lip": (0.0, -42.0, 101.0),
    "lower lip": (0.0, -50.0, 100.0),
    "wing of the nose": (15.0, -20.0, 101.0),
    "chin": (0.0, -78.0, 94.0),
}
FROM_MIDLINE = (0, 5, 10, 15, 20)  # millimetres on the right
ROUNDING = 1e-9  # metres, of the place of vertices on the midline, which are of neither half


@dataclass(frozen=True)
class Row:
    """An action, what is looked at, and what is published of it."""

    action: str
    what: str
    published: str
    weights: dict[str, float]
    measure: Callable[[Face], str]


class Face:
    """Displacement of the visible surface of one equilibrium."""

    def __init__(self, anatomy: Anatomy, parameters: FloatArray, u: FloatArray) -> None:
        self._anatomy, self._parameters = anatomy, parameters
        surface = anatomy.surface
        self._rest = 1e3 * surface.points + SELLION
        self._shape = Warp(ADULT)
        self._moved = 1e3 * (surface.weights @ u)

    def of(self, place: str) -> FloatArray:
        """Motion (3,) of the nearest visible point, mm."""
        return self._moved[self._nearest(np.array([PLACES[place]]))[0]]

    def _nearest(self, sculpted: FloatArray) -> IntArray:
        """Visible points (k,) nearest to places (k, 3) on the head as sculpted."""
        found: IntArray = cKDTree(self._rest).query(self._shape(sculpted))[1]
        return found

    def mouth_width(self) -> float:
        """Change of the width of the mouth, as a share."""
        corner = self._nearest(np.array([PLACES["corner of the mouth"]]))[0]
        return float(self._moved[corner, 0] / self._rest[corner, 0])

    def incisal_opening(self) -> float:
        """Distance that the lower incisors travel, mm."""
        poses = self._anatomy.poses
        point = 1e-3 * (self._shape(np.array([INCISAL_EDGE])) - SELLION)
        lifts = poses.lift_coordinates(self._parameters[len(self._anatomy.muscles) :])[: poses.jaw.lift_count]
        return float(1e3 * np.linalg.norm(np.tensordot(lifts, poses.jaw.unit_motions(point), axes=1)))


def motion(place: str) -> Callable[[Face], str]:
    """Measure the motion of a place: length, and out, up, forward."""

    def measured(face: Face) -> str:
        out, up, forward = face.of(place)
        return f"{np.linalg.norm(face.of(place)):.1f} ({out:+.1f}, {up:+.1f}, {forward:+.1f})"

    return measured


ROWS = (
    Row("AU12", "corner of the mouth", "9.3 ± 2.8, up and outwards", {"AU12": 1}, motion("corner of the mouth")),
    Row("AU1+2", "middle of the brow", "10.6 ± 2.5 up", {"AU1": 1, "AU2": 1}, motion("middle of the brow")),
    Row("AU4", "inner brow", "together and down", {"AU4": 1}, motion("inner brow")),
    Row("AU26", "lower incisors", "at least 20", {"AU26": 1}, lambda face: f"{face.incisal_opening():.1f}"),
    Row("AU27", "lower incisors", "40 to 50", {"AU27": 1}, lambda face: f"{face.incisal_opening():.1f}"),
    Row("AU9", "wing of the nose", "up", {"AU9": 1}, motion("wing of the nose")),
    Row("AU9", "upper lip", "up", {"AU9": 1}, motion("upper lip")),
    Row("AU10", "upper lip", "up", {"AU10": 1}, motion("upper lip")),
    Row("AU10", "wing of the nose", "up", {"AU10": 1}, motion("wing of the nose")),
    Row("AU15", "corner of the mouth", "down", {"AU15": 1}, motion("corner of the mouth")),
    Row("AU16", "lower lip", "down", {"AU16": 1}, motion("lower lip")),
    Row("AU17", "chin", "up", {"AU17": 1}, motion("chin")),
    Row("AU18", "width of the mouth", "15 % less", {"AU18": 1}, lambda face: f"{100 * face.mouth_width():+.0f} %"),
    Row("AU18", "upper lip", "forward", {"AU18": 1}, motion("upper lip")),
    Row("AU18", "lower lip", "forward", {"AU18": 1}, motion("lower lip")),
    Row("AU20", "corner of the mouth", "outwards", {"AU20": 1}, motion("corner of the mouth")),
)  # fmt: skip


def main() -> None:
    """Print the table in Markdown."""
    anatomy = built_in_head(sys.argv[1] if len(sys.argv) > 1 else "standard")
    solver = EquilibriumSolver(EffectChoice(ContactChoice.LIPS).model(anatomy))
    print("| action | what | published, mm | ours, mm |\n|---|---|---|---|")
    faces: dict[str, Face] = {}
    for row in ROWS:
        if row.action not in faces:
            parameters = anatomy.inputs.to_parameters(anatomy.inputs.weights(row.weights))
            faces[row.action] = Face(anatomy, parameters, solver.solve(parameters).u)
        print(f"| {row.action} | {row.what} | {row.published} | {row.measure(faces[row.action])} |", flush=True)
    print_one_sided(anatomy, solver)


def print_one_sided(anatomy: Anatomy, solver: EquilibriumSolver) -> None:
    """Print the largest motion on the right of units on the left alone, by distance from the midline."""
    skin = anatomy.surface
    print("| on the left alone | peak, mm |" + "".join(f" beyond {far} mm |" for far in FROM_MIDLINE))
    print("|---" * (2 + len(FROM_MIDLINE)) + "|")
    for name in (name for name in anatomy.inputs.names if name.startswith("AU") and name.endswith("_L")):
        parameters = anatomy.inputs.to_parameters(anatomy.inputs.weights({name: 1.0}))
        moved = np.linalg.norm(skin.weights @ solver.solve(parameters).u, axis=1)
        shares = [moved[skin.points[:, 0] < -1e-3 * far - ROUNDING].max() / moved.max() for far in FROM_MIDLINE]
        cells = "".join(f" {100 * share:.0f} % |" for share in shares)
        print(f"| {name.removesuffix('_L')} | {1e3 * moved.max():.1f} |{cells}", flush=True)


if __name__ == "__main__":
    main()
