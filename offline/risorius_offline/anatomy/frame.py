"""Units and axes of a source, and the transformation into ours: x to the person's left, y up, z forwards, metres."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from risorius.errors import InputError
from risorius.jaw import FloatArray

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}

DIRECTIONS = {
    "left": (1.0, 0.0, 0.0),
    "right": (-1.0, 0.0, 0.0),
    "superior": (0.0, 1.0, 0.0),
    "inferior": (0.0, -1.0, 0.0),
    "anterior": (0.0, 0.0, 1.0),
    "posterior": (0.0, 0.0, -1.0),
}

# A head is 0.1 to 0.4 m across; anything else is a mistake in the units.
SMALLEST_FACE, LARGEST_FACE = 0.05, 0.6


@dataclass(frozen=True)
class Frame:
    """Rotation (3, 3) and scale that take source coordinates into ours (up to the origin)."""

    rotation: FloatArray
    scale: float

    def to_ours(self, points: FloatArray) -> FloatArray:
        """Points (n, 3) of the source in our axes and metres."""
        return self.scale * np.asarray(points, dtype=np.float64) @ self.rotation.T


def parse_frame(text: str, units: str, where: str) -> Frame:
    """Frame of a description such as `x: anterior to posterior, y: lateral, z: inferior to superior`.

    Each axis runs from its first to its second direction (right/left, inferior/superior, posterior/anterior); signs in
    brackets and other remarks are ignored. At most one axis may be `lateral`: it completes a right-handed frame.
    Raises InputError that names `where`, the item and the remedy.
    """
    if units not in UNITS:
        raise InputError(f"{where}: units {units!r} are not known; write one of {', '.join(UNITS)}")
    axes: dict[str, FloatArray] = {}
    for axis, description in re.findall(r"([xyz])\s*:\s*([^;]*?)(?=,\s*[xyz]\s*:|;|$)", text.lower()):
        ends = re.findall("|".join(DIRECTIONS), description)
        if len(ends) >= 2:
            axes[axis] = np.array(DIRECTIONS[ends[1]])
    if len(axes) == 2:
        (missing,) = set("xyz") - set(axes)
        following = {"x": "yz", "y": "zx", "z": "xy"}[missing]
        axes[missing] = np.cross(axes[following[0]], axes[following[1]])
    rotation = np.column_stack([axes[a] for a in "xyz"]) if len(axes) == 3 else np.zeros((3, 3))
    if not np.isclose(np.linalg.det(rotation), 1.0):
        raise InputError(
            f"{where}: frame {text!r} does not name three axes of a right-handed frame; "
            "write for instance 'x: right to left, y: inferior to superior, z: posterior to anterior'"
        )
    return Frame(rotation, UNITS[units])


def check_size(points: FloatArray, units: str, where: str) -> None:
    """Raise InputError when points (n, 3), in metres, cannot be a face: the units are wrong."""
    width = float(np.ptp(points, axis=0).max())
    if not SMALLEST_FACE <= width <= LARGEST_FACE:
        raise InputError(
            f"{where}: the mesh is {width / UNITS[units]:.4g} {units} wide, a face is 0.1 to 0.4 m; "
            f"correct 'units' in muscles.json (now {units!r})"
        )
