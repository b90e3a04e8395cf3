"""What the deep side of the face is held by: skull, mandible, lid plates, or nothing.

Regions are told by the place of the deep node in the frame of `skin.py`, millimetres. Free are lips and cheeks in front
of teeth and gums, the wings of the nose, the lids and the floor of the mouth with the neck (the seed's natural
boundary).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from risorius.jaw import FloatArray
from risorius_offline.head.skin import EYE_CENTRE, EYE_RADIUS

Flags = npt.NDArray[np.bool_]

VESTIBULE = (-62.0, -25.0)  # height of its lower and upper fornix
MASSETER_FRONT = 44.0  # z of its anterior border; cheeks are free in front of it
CHEEK_TOP = -16.0  # where cheeks hang from the zygoma
ORBIT = 23.0  # from the eyeball's centre: soft tissue within it lies on no bone
WINGS = (5.0, 20.0, -8.0, -27.0)  # of the nose: x from, to; y below, above
CHIN_BOTTOM = -84.0
JAW_TO_RIM = 22.0  # no closer to the held rim does tissue follow the mandible
PLATE_THICKNESS = 8.0
BROW, GLABELLA, TEMPORAL_LINE, SCALP = 27.0, 10.0, 50.0, 12.0  # where the forehead begins to glide on the bone
MARGIN = 1.0  # of the lid, up to which all layers are part of the plate
CANTHUS = 1.6  # about the corner of the eye, held by its tendon in all layers
PLATE_REACH = 1.0  # height of the tarsal plate above the lid margin
LEFT, RIGHT = 1, 2


@dataclass(frozen=True)
class Attachments:
    """Flags (n,) of the deep nodes held by each; lids: 0, LEFT or RIGHT plate."""

    skull: Flags
    jaw: Flags
    lids: npt.NDArray[np.int8]
    margin: Flags
    canthi: Flags


def attachments(deep: FloatArray, to_rim: FloatArray, margins: FloatArray) -> Attachments:
    """Attachments of deep nodes (n, 3).

    to_rim (n,): distance to the held rim of the sheet. margins (k, 3): of the left upper lid.
    """
    x, y, z = np.abs(deep[:, 0]), deep[:, 1], deep[:, 2]
    to_eye = np.linalg.norm(np.column_stack([x, y, z]) - np.asarray(EYE_CENTRE), axis=1)
    orbit = to_eye < ORBIT
    cheek = (z > MASSETER_FRONT) & (y > VESTIBULE[0]) & (y < np.where(x > 30.0, CHEEK_TOP, VESTIBULE[1]))
    wings = (x > WINGS[0]) & (x < WINGS[1]) & (y < WINGS[2]) & (y > WINGS[3]) & (z > 80.0)
    throat = (y < CHIN_BOTTOM) | ((y < -60.0) & _below_mandible(x, y, z))
    forehead = (y > np.where(x < GLABELLA, BROW + 6.0, BROW)) & (x < TEMPORAL_LINE) & (to_rim > SCALP)
    free = orbit | cheek | wings | throat | forehead
    below_hinge = (y <= VESTIBULE[0]) | ((z <= MASSETER_FRONT) & (y < CHEEK_TOP))
    rim = to_rim <= 0.0
    jaw = below_hinge & ~free & (to_rim > JAW_TO_RIM)
    skull = (~below_hinge & ~free) | rim
    corners = margins[[0, -1]]
    canthi = np.linalg.norm(np.column_stack([x, y])[:, None] - corners[None, :, :2], axis=2).min(axis=1) < CANTHUS
    plate = (
        (to_eye < EYE_RADIUS + PLATE_THICKNESS)
        & (y > np.interp(x, margins[:, 0], margins[:, 1]) - 0.5)
        & (y < np.interp(x, margins[:, 0], margins[:, 1]) + PLATE_REACH)
        & ~canthi
        & (x > margins[0, 0])
        & (x < margins[-1, 0])
    )
    margin = plate & (y < np.interp(x, margins[:, 0], margins[:, 1]) + MARGIN)
    lids = np.where(plate & ~rim, np.where(deep[:, 0] > 0.0, LEFT, RIGHT), 0).astype(np.int8)
    return Attachments(skull | canthi, jaw, lids, margin, canthi)


def _below_mandible(x: FloatArray, y: FloatArray, z: FloatArray) -> Flags:
    """Behind and below the lower border of the mandible, from the chin to its angle."""
    border = np.interp(z, [15.0, 46.0, 72.0], [-48.0, -63.0, -79.0])
    result: Flags = y < border
    return result
