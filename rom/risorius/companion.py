"""Rigid things that are seen with a face and have no tissue: eyeballs, teeth, the scalp with the ears."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import h5py
import numpy as np
import numpy.typing as npt

from risorius.errors import InputError
from risorius.jaw import FloatArray, JawMotion
from risorius.poses import Poses
from risorius.surface import Colours

SKULL, JAW = "skull", "jaw"


@dataclass(frozen=True)
class Companion:
    """A rigid thing beside the face: points (k, 3) at rest, metres; triangles (t, 3), outward; colours (k, 3) sRGB.

    moves_with: SKULL, which stays where it is, or JAW. Raises InputError for anything else.
    """

    points: FloatArray
    triangles: npt.NDArray[np.int64]
    colours: Colours
    moves_with: str = SKULL

    def __post_init__(self) -> None:
        if self.moves_with not in (SKULL, JAW):
            raise InputError(f"companion: moves_with {self.moves_with!r}; give {SKULL!r} or {JAW!r}")

    def unit_transforms(self, poses: Poses) -> FloatArray:
        """(c, 4, 4), so that I + sum_k q_k T_k moves homogeneous points; q are the coordinates of a face.

        The first coordinates of a face are the lift coordinates of its jaw, in which a rigid motion is linear; a
        companion of the skull, or of a face without a jaw, has none.
        """
        if self.moves_with == SKULL or poses.jaw is None:
            return np.zeros((0, 4, 4))
        return unit_transforms(poses.jaw)

    def posed(self, poses: Poses, coordinates: npt.NDArray[np.floating]) -> FloatArray:
        """Points (k, 3) where the coordinates (r,) of a frame, or the lift coordinates of its poses, put them."""
        transforms = self.unit_transforms(poses)
        motion = np.tensordot(coordinates[: len(transforms)], transforms, axes=1)
        result: FloatArray = self.points + self.points @ motion[:3, :3].T + motion[:3, 3]
        return result

    def write(self, group: h5py.Group) -> None:
        """Store the companion in a group of its own."""
        group["points"], group["triangles"], group["colours"] = self.points, self.triangles, self.colours
        group.attrs["moves_with"] = self.moves_with

    @classmethod
    def read(cls, group: h5py.Group) -> Companion:
        """Load what `write` stored."""
        points, triangles, colours = (group[name][()] for name in ("points", "triangles", "colours"))
        return cls(points, triangles, colours, str(group.attrs["moves_with"]))


def unit_transforms(jaw: JawMotion) -> FloatArray:
    """(4, 4, 4) of homogeneous points of the jaw, so that I + sum_k q_k T_k moves them; q are lift coordinates."""
    at_origin, *at_axes = np.moveaxis(jaw.unit_motions(np.vstack([np.zeros(3), np.eye(3)])), 1, 0)
    transforms = np.zeros((jaw.lift_count, 4, 4))
    transforms[:, :3, :3] = np.stack([moved - at_origin for moved in at_axes], axis=-1)
    transforms[:, :3, 3] = at_origin
    return transforms


def posed_companions(
    companions: Mapping[str, Companion], poses: Poses, coordinates: npt.NDArray[np.floating]
) -> list[Companion]:
    """Companions where the coordinates of a frame, or the lift coordinates of its poses, put them."""
    return [replace(item, points=item.posed(poses, coordinates)) for item in companions.values()]


def write_companions(group: h5py.Group, companions: Mapping[str, Companion]) -> None:
    """Store companions by name in `companions`."""
    stored = group.create_group("companions")
    for name, companion in companions.items():
        companion.write(stored.create_group(name))


def read_companions(group: h5py.Group) -> dict[str, Companion]:
    """Load what `write_companions` stored."""
    return {name: Companion.read(item) for name, item in group["companions"].items()}
