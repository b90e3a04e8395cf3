"""How a muscle pulls: by an active stress along its fibres (7.2), or by a force density (7.3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import h5py

from risorius_offline.muscles.insertion_cone import InsertionCone


class Load(Protocol):
    """What acts along the fibres at full activation."""

    kind: ClassVar[str]

    def write(self, group: h5py.Group) -> None:
        """Store the load in an HDF5 group."""
        ...


@dataclass(frozen=True)
class ActiveStress:
    """T tau (x) tau of (7.2), which follows the deformed fibres. max_stress: T at activation 1, pascals."""

    max_stress: float
    kind: ClassVar[str] = "active_stress"

    def write(self, group: h5py.Group) -> None:
        """Store the stress."""
        group.attrs["max_stress"] = self.max_stress

    @classmethod
    def read(cls, group: h5py.Group) -> ActiveStress:
        """Load what `write` stored."""
        return cls(float(group.attrs["max_stress"]))


@dataclass(frozen=True)
class Insertion:
    """The cone at the end of a muscle. magnitude: lambda in it at activation 1, N/m^3."""

    cone: InsertionCone
    magnitude: float


@dataclass(frozen=True)
class ForceDensity:
    """lambda tau of (7.3), a dead load: it keeps its place and direction in the undeformed tissue.

    magnitude: lambda in the muscle at activation 1, N/m^3. insertion: its prolongation, where it has one; tissue of
    both belongs to the insertion.
    """

    magnitude: float
    insertion: Insertion | None = None
    kind: ClassVar[str] = "force_density"

    def write(self, group: h5py.Group) -> None:
        """Store magnitudes and cone."""
        group.attrs["magnitude"] = self.magnitude
        if self.insertion:
            cone = self.insertion.cone
            group.create_group("insertion").attrs.update(
                magnitude=self.insertion.magnitude, radius=cone.radius, apex_angle=cone.apex_angle
            )

    @classmethod
    def read(cls, group: h5py.Group) -> ForceDensity:
        """Load what `write` stored."""
        if "insertion" not in group:
            return cls(float(group.attrs["magnitude"]))
        radius, angle, magnitude = (
            float(group["insertion"].attrs[key]) for key in ("radius", "apex_angle", "magnitude")
        )
        return cls(float(group.attrs["magnitude"]), Insertion(InsertionCone(radius, angle), magnitude))


LOADS = {kind.kind: kind for kind in (ActiveStress, ForceDensity)}
