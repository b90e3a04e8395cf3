"""Action units and head pose of OpenFace 2 (Baltrusaitis et al. 2018): columns of its CSV file.

Action units are the columns `AU01_r` to `AU45_r`. An intensity runs from 0 (not present) over 1 (minimum) to 5
(maximum), continuously: FACS A to E. OpenFace does not tell the sides apart. All other columns, the presences `AU01_c`
too, are left alone: AU28, of which it gives the presence only, does not come out.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from scipy.spatial.transform import Rotation

from risorius.errors import InputError
from risorius.jaw import FloatArray

LARGEST = 5.0  # FACS E
ROTATIONS = ("pose_Rx", "pose_Ry", "pose_Rz")
STANDARD_GRAVITY = 9.81

_INTENSITY = re.compile(r"AU(\d+)_r")


def action_units(row: Mapping[str, float | str]) -> dict[str, float]:
    """Weights in [0, 1] by input name of one row, as csv.DictReader gives it or as numbers.

    Raises InputError when the row has no intensity, or one that is not a number in [0, 5].
    """
    weights = {}
    for column, value in row.items():
        match = _INTENSITY.fullmatch(column.strip())  # older releases put a space after the comma
        if match:
            weights[f"AU{int(match[1])}"] = _checked(column.strip(), value) / LARGEST
    if not weights:
        raise InputError(
            f"OpenFace row: no column like AU01_r among {', '.join(row) or 'none'}; run OpenFace with -aus"
        )
    return weights


def gravity(row: Mapping[str, float | str]) -> FloatArray:
    """Gravity (3,), m/s2 in the frame of the head, of one row, for a camera that is upright.

    The rotation of the head is Rx Ry Rz, radians about axes to the right of the picture, down, and away from the
    camera. Raises InputError when one of the angles is not a finite number.
    """
    angles = []
    for column in ROTATIONS:
        try:
            angles.append(float(row[column]))
        except (KeyError, TypeError, ValueError):
            angles.append(math.nan)
        if not math.isfinite(angles[-1]):
            raise InputError(f"{column}: {row.get(column)!r} is not an angle in radians; leave the row out")
    turned = Rotation.from_euler("XYZ", angles).inv().apply([0.0, STANDARD_GRAVITY, 0.0])
    return turned * [1.0, -1.0, -1.0]  # y up and z out of the face, here


def _checked(column: str, value: float | str) -> float:
    try:
        intensity = float(value)
    except ValueError:
        intensity = math.nan
    if not 0.0 <= intensity <= LARGEST:
        raise InputError(f"{column}: intensity {value!r} is not a number in [0, {LARGEST:g}]; leave the row out")
    return intensity
