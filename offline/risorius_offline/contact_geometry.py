"""What of an anatomy a reduced model needs to know to keep the skin that is seen out of teeth and out of itself."""

from __future__ import annotations

import numpy as np

from risorius.companion import JAW, SKULL
from risorius.contact_geometry import ContactGeometry, Obstacle
from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.anatomy.anatomy import Anatomy, Surface
from risorius_offline.anatomy.folder import JAW_BONE
from risorius_offline.effects.contact_surface import ContactSurface
from risorius_offline.effects.lip_seam import facing_pairs
from risorius_offline.effects.triangle_distance import signed_distances

TEETH = "teeth"  # names of the companions that are teeth begin so
SPACING, BAND = 0.75e-3, 6e-3  # metres
AROUND_LIPS = 30e-3  # beyond the seam, as far as bones are kept


def contact_geometry(anatomy: Anatomy) -> ContactGeometry:
    """Teeth, or bones around the lips where no teeth are seen, and the pairs of the seam on the visible surface.

    Raises InputError that names a surface whose sides cannot be told.
    """
    visible = anatomy.visible_surface
    surface = ContactSurface.of_triangles(visible.points, visible.triangles)
    seam = facing_pairs(surface)
    return ContactGeometry(_obstacles(anatomy, visible.points[seam[:, 0]]), seam)


def _obstacles(anatomy: Anatomy, lips: FloatArray) -> dict[str, Obstacle]:
    teeth = {name: item for name, item in anatomy.companions.items() if name.startswith(TEETH)}
    if teeth:
        return {
            name: _obstacle(name, Surface(item.points, item.triangles), item.moves_with) for name, item in teeth.items()
        }
    found = {name: _obstacle(name, bone, JAW if name == JAW_BONE else SKULL) for name, bone in anatomy.bones.items()}
    cut = {name: _cut(bone, lips) for name, bone in found.items()} if len(lips) else found
    return {name: bone for name, bone in cut.items() if bone.distances.size}


def _obstacle(name: str, surface: Surface, moves_with: str) -> Obstacle:
    """Distances on a grid about the middle of a surface: mirror images have distances that are mirror images."""
    low, high = surface.points.min(axis=0), surface.points.max(axis=0)
    nx, ny, nz = (int(n) + 2 for n in (high - low + 2.0 * BAND) / SPACING)
    origin = 0.5 * (low + high) - 0.5 * SPACING * (np.array([nx, ny, nz]) - 1)
    try:
        distances = signed_distances(surface, origin, SPACING, (nx, ny, nz), BAND)
    except InputError as error:
        raise InputError(f"{name!r}: {error}") from error
    return Obstacle(origin, SPACING, distances.astype(np.float32), moves_with)


def _cut(obstacle: Obstacle, lips: FloatArray) -> Obstacle:
    """The part of an obstacle around points (k, 3)."""
    shape = np.array(obstacle.distances.shape)
    first = np.floor((lips.min(axis=0) - AROUND_LIPS - obstacle.origin) / obstacle.spacing).astype(np.int64)
    last = np.ceil((lips.max(axis=0) + AROUND_LIPS - obstacle.origin) / obstacle.spacing).astype(np.int64)
    first, last = np.clip(first, 0, shape), np.clip(last, 0, shape)
    kept = obstacle.distances[first[0] : last[0], first[1] : last[1], first[2] : last[2]]
    return Obstacle(obstacle.origin + obstacle.spacing * first, obstacle.spacing, kept, obstacle.moves_with)
