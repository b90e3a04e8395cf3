"""A head as sculpted, given other proportions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from risorius.companion import Companion
from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.anatomy.anatomy import Anatomy, Surface
from risorius_offline.head.proportions import Proportions
from risorius_offline.head.quality import scaled_jacobians
from risorius_offline.head.warp import LANDMARKS, Warp
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.polyline_fibres import PolylineFibres

SELLION = np.array(LANDMARKS["n"])  # the origin; it stays where it is
MILLIMETRES = 1e3


def reshaped(head: Anatomy, proportions: Proportions) -> Anatomy:
    """Head with given proportions from one as sculpted; raises InputError where these turn a cell inside out.

    All that has a place moves with one map of space. Eyeballs stay spheres.
    """
    shape = _Shape(Warp(proportions))
    points = shape.points(head.points)
    _check(points, head, proportions)
    jaw, lids, surface = head.jaw_motion, head.lid_motion, head.surface
    return replace(
        head,
        points=points,
        muscles=tuple(shape.muscle(muscle) for muscle in head.muscles),
        jaw_motion=jaw and replace(jaw, condyle_centre=shape.point(jaw.condyle_centre)),
        lid_motion=lids and replace(lids, centres=(shape.point(lids.centres[0]), shape.point(lids.centres[1]))),
        surface=surface and replace(surface, points=shape.points(surface.points)),
        companions={name: shape.companion(name, item) for name, item in head.companions.items()},
        bones={name: Surface(shape.named(name, bone.points), bone.triangles) for name, bone in head.bones.items()},
        provenance={**head.provenance, "proportions": proportions.provenance()},
    )


class _Shape:
    """A warp in metres from the sellion."""

    def __init__(self, warp: Warp) -> None:
        self._warp = warp

    def points(self, points: FloatArray) -> FloatArray:
        result: FloatArray = (self._warp(MILLIMETRES * points + SELLION) - SELLION) / MILLIMETRES
        return result

    def named(self, name: str, points: FloatArray) -> FloatArray:
        """Points of a bone or companion."""
        if "eyeball" not in name:
            return self.points(points)
        result: FloatArray = (self._warp.eyeball(MILLIMETRES * points + SELLION) - SELLION) / MILLIMETRES
        return result

    def point(self, point: tuple[float, float, float]) -> tuple[float, float, float]:
        x, y, z = (float(c) for c in self.points(np.array([point]))[0])
        return x, y, z

    def muscle(self, muscle: Muscle) -> Muscle:
        if not isinstance(muscle.fibres, PolylineFibres):
            raise InputError(f"muscle {muscle.name!r}: its fibres are no lines, which alone can be given proportions")
        return replace(muscle, fibres=replace(muscle.fibres, lines=tuple(self.points(k) for k in muscle.fibres.lines)))

    def companion(self, name: str, item: Companion) -> Companion:
        return replace(item, points=self.named(name, item.points))


def _check(points: FloatArray, head: Anatomy, proportions: Proportions) -> None:
    smallest = min(float(scaled_jacobians(points, block.connectivity).min()) for block in head.cells)
    if smallest <= 0.0:
        name, off = proportions.farthest()
        raise InputError(
            f"proportions: cells are turned inside out (scaled Jacobian {smallest:.3f}); bring the distances nearer to "
            f"the means, first {name}, which is {off:+.1f} standard deviations away"
        )
