"""A muscle: a name, the construction of its fibres and its load."""

from __future__ import annotations

from dataclasses import dataclass

import h5py

from risorius.errors import InputError
from risorius_offline.muscles.deformation_fibres import DeformationFibres
from risorius_offline.muscles.fibres import Fibres
from risorius_offline.muscles.laplace_fibres import LaplaceFibres
from risorius_offline.muscles.loads import LOADS, ForceDensity, Load
from risorius_offline.muscles.polyline_fibres import PolylineFibres
from risorius_offline.muscles.radial_fibres import RadialFibres
from risorius_offline.muscles.ring_fibres import RingFibres
from risorius_offline.muscles.spline_fibres import SplineFibres

CONSTRUCTIONS = {
    kind.kind: kind
    for kind in (PolylineFibres, SplineFibres, LaplaceFibres, DeformationFibres, RingFibres, RadialFibres)
}


@dataclass(frozen=True)
class Muscle:
    """name as in `risorius.facs`, with `_L` or `_R` where there are two; where and along what it pulls, and how."""

    name: str
    fibres: Fibres
    load: Load

    def __post_init__(self) -> None:
        if isinstance(self.load, ForceDensity) and isinstance(self.fibres, RingFibres):
            raise InputError(
                f"muscle {self.name!r}: a force density along a ring turns the tissue instead of narrowing the ring; "
                "give it an active stress or radial fibres"
            )

    def write(self, group: h5py.Group) -> None:
        """Store the muscle in an HDF5 group."""
        group.attrs["name"] = self.name
        for key, part in (("fibres", self.fibres), ("load", self.load)):
            item = group.create_group(key)
            item.attrs["kind"] = part.kind
            part.write(item)

    @classmethod
    def read(cls, group: h5py.Group) -> Muscle:
        """Load what `write` stored."""
        fibres, load = group["fibres"], group["load"]
        return cls(
            name=str(group.attrs["name"]),
            fibres=CONSTRUCTIONS[fibres.attrs["kind"]].read(fibres),
            load=LOADS[load.attrs["kind"]].read(load),
        )
