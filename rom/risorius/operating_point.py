"""A way to run a model, with the accuracy and the time that were measured for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass

import h5py

from risorius import storage
from risorius.accuracy import Errors
from risorius.error_bound import ErrorBound
from risorius.evaluators.setting import Setting


@dataclass(frozen=True)
class Seconds:
    """Processor time of a frame, reconstruction included, with every input in use, which is the most it can cost."""

    median: float
    p99: float


@dataclass(frozen=True)
class OperatingPoint:
    """A setting, errors on the held-out snapshots of each kind and of all together, time, and the bound of a frame."""

    setting: Setting
    errors: Mapping[str, Errors]
    overall: Errors
    seconds: Seconds
    bound: ErrorBound

    @property
    def frame_error(self) -> float:
        """Metres: on 95 % of frames, of whatever kind, no vertex is further off."""
        return max(errors.frame for errors in self.errors.values())

    @property
    def p95(self) -> float:
        """Metres: no more than 5 % of the vertices are further off, whatever the kind of input."""
        return max(errors.p95 for errors in self.errors.values())

    def write(self, group: h5py.Group) -> None:
        """Store all fields."""
        for name in ("setting", "overall", "seconds", "bound"):
            group.create_group(name).attrs.update(asdict(getattr(self, name)))
        kinds = group.create_group("errors")
        for kind, errors in self.errors.items():
            kinds.create_group(kind).attrs.update(asdict(errors))

    @classmethod
    def read(cls, group: h5py.Group) -> OperatingPoint:
        """Load what `write` stored."""
        return cls(
            setting=Setting(**storage.plain_attributes(group["setting"])),
            errors={kind: Errors(**storage.plain_attributes(one)) for kind, one in group["errors"].items()},
            overall=Errors(**storage.plain_attributes(group["overall"])),
            seconds=Seconds(**storage.plain_attributes(group["seconds"])),
            bound=ErrorBound(**storage.plain_attributes(group["bound"])),
        )


def most_accurate(points: tuple[OperatingPoint, ...]) -> OperatingPoint:
    """Return the one that 95 % of the vertices are closest at."""
    return min(points, key=lambda point: point.p95)
