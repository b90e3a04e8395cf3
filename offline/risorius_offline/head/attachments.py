"""What the deep side of the face is held by: skull, mandible, lid plates, or nothing.

Regions are told by the place of the deep node in the frame of `skin.py`, millimetres. Free are lips and cheeks in front
of teeth and gums but for the frenula, the wings of the nose, the lids and the floor of the mouth with the neck (the
seed's natural boundary).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from risorius.jaw import FloatArray
from risorius_offline.anatomy.anatomy import LEFT_LID, RIGHT_LID
from risorius_offline.head.skin import EYE_RADIUS, distance_to_eye

Flags = npt.NDArray[np.bool_]

VESTIBULE = (-62.0, -25.0)  # height of its lower and upper fornix
FRENULA = (-56.5, -33.0)  # where the frenula of the lips, which run from the fornices along the midline, leave the gums
FRENULUM = 1.0  # half of its width
MASSETER_FRONT = 44.0  # z of its anterior border; cheeks are free in front of it
CHEEK_TOP = -16.0  # where cheeks hang from the zygoma
ORBIT = 23.0  # from the eyeball's centre: soft tissue within it lies on no bone
WINGS = (5.0, 20.0, -8.0, -27.0)  # of the nose: x from, to; y below, above
CHIN_BOTTOM = -84.0
JAW_TO_RIM = 34.0  # no closer to the held rim does tissue follow the mandible, whose angle swings towards it
# Where the galea glides on the bone: above the brow, less far down at the glabella, within the temporal lines.
BROW, BROW_AT_GLABELLA, GLABELLA, TEMPORAL_LINE, SCALP = 27.0, 33.0, 10.0, 50.0, 12.0
CANTHUS = 1.6  # about the corner of the eye, held by its tendon
PLATE_END = 3.2  # no closer to the corner is tissue part of the plate: what is between has to bear its turning
# The tarsal plate: nodes about the margin of the upper lid, and how far in front of the eyeball they are sought.
BELOW_MARGIN, ABOVE_MARGIN, PLATE_DEPTH = 0.5, 1.0, 8.0


@dataclass(frozen=True)
class Attachments:
    """Flags (n,) of the sheet's nodes, and lids: 0, LEFT_LID or RIGHT_LID.

    Skull and jaw hold the deep nodes; canthi, to the skull, and lids those of all layers. forehead: deep nodes, held by
    the skull, on which loose areolar tissue lets the galea glide.
    """

    skull: Flags
    jaw: Flags
    canthi: Flags
    lids: npt.NDArray[np.int8]
    forehead: Flags


def attachments(deep: FloatArray, to_rim: FloatArray, margins: FloatArray) -> Attachments:
    """Attachments of deep nodes (n, 3).

    to_rim (n,): distance to the held rim of the sheet. margins (k, 3): of the left upper lid.
    """
    x, y, z = np.abs(deep[:, 0]), deep[:, 1], deep[:, 2]
    to_eye = distance_to_eye(deep)
    orbit = to_eye < ORBIT
    cheek = (z > MASSETER_FRONT) & (y > VESTIBULE[0]) & (y < np.where(x > 30.0, CHEEK_TOP, VESTIBULE[1]))
    upper_frenulum = cheek & (x < FRENULUM) & (y > FRENULA[1])
    lower_frenulum = cheek & (x < FRENULUM) & (y < FRENULA[0])
    cheek &= ~(upper_frenulum | lower_frenulum)
    wings = (x > WINGS[0]) & (x < WINGS[1]) & (y < WINGS[2]) & (y > WINGS[3]) & (z > 80.0)
    throat = (y < CHIN_BOTTOM) | ((y < -60.0) & _below_mandible(x, y, z))
    forehead = (y > np.where(x < GLABELLA, BROW_AT_GLABELLA, BROW)) & (x < TEMPORAL_LINE) & (to_rim > SCALP)
    forehead &= ~orbit
    free = orbit | cheek | wings | throat
    below_hinge = lower_frenulum | (y <= VESTIBULE[0]) | ((z <= MASSETER_FRONT) & (y < CHEEK_TOP))
    rim = to_rim <= 0.0
    jaw = below_hinge & ~free & (to_rim > JAW_TO_RIM)
    skull = (~below_hinge & ~free) | rim
    corners = margins[[0, -1], :2]
    to_corner = np.linalg.norm(np.column_stack([x, y])[:, None] - corners, axis=2).min(axis=1)
    above = y - np.interp(x, margins[:, 0], margins[:, 1])
    plate = (above > -BELOW_MARGIN) & (above < ABOVE_MARGIN) & (to_eye < EYE_RADIUS + PLATE_DEPTH)
    plate &= (x > margins[0, 0]) & (x < margins[-1, 0]) & (to_corner > PLATE_END)
    lids = np.where(plate, np.where(deep[:, 0] > 0.0, LEFT_LID, RIGHT_LID), 0).astype(np.int8)
    return Attachments(skull, jaw, to_corner < CANTHUS, lids, forehead)


def _below_mandible(x: FloatArray, y: FloatArray, z: FloatArray) -> Flags:
    """Behind and below the lower border of the mandible, from the chin to its angle."""
    border = np.interp(z, [15.0, 46.0, 72.0], [-48.0, -63.0, -79.0])
    result: Flags = y < border
    return result
