"""Contact of made-up surfaces, and a face before a wall that its jaw pushes it into."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from risorius.contact_geometry import ContactGeometry, Obstacle
from risorius.effects.contact import Contact
from risorius.effects.contact_tables import contact_tables
from risorius.effects.retreat import Retreat
from risorius.jaw import JawMotion
from risorius.model import ReducedModel
from risorius.poses import Poses

JAW_MOTION = JawMotion((0.0, -0.02, -0.06), 0.45, 0.008, 0.005, 0.008)
NO_SEAM = np.zeros((0, 2), dtype=np.int64)
AT_REST = np.zeros(4)


def contact_of(
    geometry: ContactGeometry,
    rest: npt.NDArray[np.floating],
    triangles: npt.NDArray[np.int32],
    pressed: npt.NDArray[np.floating],
    carriers: int = 5,
) -> Contact:
    """Contact of a surface that in its only frame of training is `pressed`; the jaw takes no tissue with it."""
    rest, poses = rest.astype(np.float32), Poses(JAW_MOTION)
    tables = contact_tables(geometry, poses, rest, triangles, [(AT_REST, pressed)])
    touching = np.union1d(tables.points, tables.vertices)
    retreat = Retreat.of(geometry, poses, np.zeros((4, len(rest), 3)), rest, triangles, touching)
    return Contact(tables, retreat, geometry, carriers)


def walled(model: ReducedModel) -> ReducedModel:
    """An opened jaw takes the whole face up to 35 mm into a wall behind it; sweeps move nothing by more than 8 mm."""
    rest = model.rest_vertices
    lowest, spacing = np.array([-0.08, -0.14, -0.06]), 5e-3
    depth = lowest[2] + spacing * np.arange(24) - (rest[:, 2].min() - 2e-3)
    wall = Obstacle(lowest, spacing, np.broadcast_to(depth, (33, 40, 24)).astype(np.float32))
    geometry = ContactGeometry({"wall": wall}, NO_SEAM)
    contact = contact_of(geometry, rest, model.triangles, rest - [0.0, 0.0, 0.02], len(rest))
    return replace(model, effects={"contact": contact})
