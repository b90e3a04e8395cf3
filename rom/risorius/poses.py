"""All prescribed motions of a face: the mandible's and the upper eyelids', behind one vector of weights.

A pose weight is a parameter of the physics as a muscle activation is; the pose weights follow the activations in the
parameter vector. Each motion is linear in its lift coordinates, so whatever extends the unit motions into the tissue
(the lift fields) moves bones and tarsal plates exactly.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from types import MappingProxyType

import h5py
import numpy as np
import numpy.typing as npt

from risorius import storage
from risorius.jaw import FloatArray, JawMotion
from risorius.lids import LidMotion

POSE_LOWER: Mapping[str, float] = MappingProxyType(
    {"jaw_open": 0.0, "jaw_forward": -1.0, "jaw_sideways": -1.0, "upper_lid_L": -0.3, "upper_lid_R": -0.3}
)
"""Smallest admissible weight of every pose input; the largest is 1."""


@dataclass(frozen=True)
class Poses:
    """The motions that a face has; those that it lacks are None and have no inputs."""

    jaw: JawMotion | None = None
    lids: LidMotion | None = None

    @cached_property
    def motions(self) -> tuple[JawMotion | LidMotion, ...]:
        """Motions present, in the order of their weights and lift coordinates."""
        return tuple(motion for motion in (self.jaw, self.lids) if motion is not None)

    @cached_property
    def inputs(self) -> tuple[str, ...]:
        """Names of the pose weights, in order."""
        return tuple(name for motion in self.motions for name in motion.inputs)

    @cached_property
    def lift_count(self) -> int:
        """Number of lift coordinates of all motions."""
        return sum(motion.lift_count for motion in self.motions)

    def within(self, weights: npt.NDArray[np.int64]) -> Poses:
        """Return those motions that have any of some weights, by number."""
        kept, first = [], 0
        for motion in self.motions:
            end = first + len(motion.inputs)
            if ((weights >= first) & (weights < end)).any():
                kept.append(motion)
            first = end
        return Poses(self.jaw if self.jaw in kept else None, self.lids if self.lids in kept else None)

    def lift_coordinates(self, weights: npt.ArrayLike, out: FloatArray | None = None) -> FloatArray:
        """Return the lift coordinates (lift_count,) of pose weights in `inputs` order."""
        weights = np.asarray(weights)
        result = np.empty(self.lift_count) if out is None else out
        weight, lift = 0, 0
        for motion in self.motions:
            end, next_lift = weight + len(motion.inputs), lift + motion.lift_count
            motion.lift_coordinates(weights[weight:end], out=result[lift:next_lift])
            weight, lift = end, next_lift
        return result

    def lift_slopes(self, weights: npt.ArrayLike) -> FloatArray:
        """Return the derivatives (inputs, lift_count) of the lift coordinates by the pose weights."""
        weights = np.asarray(weights)
        result = np.zeros((len(self.inputs), self.lift_count))
        weight, lift = 0, 0
        for motion in self.motions:
            end, next_lift = weight + len(motion.inputs), lift + motion.lift_count
            result[weight:end, lift:next_lift] = motion.lift_slopes(weights[weight:end])
            weight, lift = end, next_lift
        return result

    def write(self, group: h5py.Group) -> None:
        """Store every motion as a group of attributes in `poses`."""
        poses = group.create_group("poses")
        for name, motion in (("jaw", self.jaw), ("lids", self.lids)):
            if motion is not None:
                poses.create_group(name).attrs.update(asdict(motion))

    @classmethod
    def read(cls, group: h5py.Group) -> Poses:
        """Load what `write` stored."""
        found = {name: storage.plain_attributes(item) for name, item in group["poses"].items()}
        return cls(
            jaw=JawMotion(**found["jaw"]) if "jaw" in found else None,
            lids=LidMotion(**found["lids"]) if "lids" in found else None,
        )
