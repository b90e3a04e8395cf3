"""What every effect of a scene has, and what it is told of the world around the face."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar, Protocol

import h5py
import numpy as np
import numpy.typing as npt

from risorius.errors import InputError
from risorius.evaluators.setting import Setting
from risorius.guard import UNFOLDED
from risorius.jaw import FloatArray
from risorius.part import Part
from risorius.snapshot_file import SnapshotSet

UPRIGHT = np.array([0.0, -9.81, 0.0])  # m/s2: y is up in every anatomy, whose shape is taken upright


@dataclass(frozen=True)
class Touch:
    """A force (3,) in newtons on a visible vertex, in the frame of the head.

    Raises InputError for a force that is not three finite numbers.
    """

    vertex: int
    force: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "force", vector(self.force, f"touch of vertex {self.vertex}: force"))


@dataclass(frozen=True)
class Surroundings:
    """What acts on a face from outside during one frame, in the frame of the head.

    step: seconds since the frame before; None where there was none, or where time has to play no part: the face is
    then as it is at rest under its loads. gravity: (3,) metres per second squared, (0, -9.81, 0) for an upright head;
    None is upright.
    """

    step: float | None = None
    gravity: FloatArray | None = None
    touches: tuple[Touch, ...] = field(default=())


class Effect(Protocol):
    """One reduced effect. It owns its state, so it is not thread-safe.

    name: of the field of `Scene` that asks for it. needs: what a model has to be trained from to have it. fields:
    (k, c, 3) float32, metres per unit of its own coordinates, at the points that carry the skin; k may be 0. Called
    for every frame, in the order of the methods.
    """

    name: ClassVar[str]
    needs: ClassVar[str]
    fields: npt.NDArray[np.float32]

    @property
    def energy(self) -> float:
        """Joules of what moves in the last frame; 0 where nothing has mass."""
        ...

    @property
    def gave_way(self) -> float:
        """Metres that it has taken any vertex from what was asked for in the last frame, where it could not show it."""
        ...

    @classmethod
    def train(cls, snapshots: SnapshotSet, fields: FloatArray) -> Effect | None:
        """Return that of a face whose coordinates have fields (r, n, 3) on all nodes; None where `needs` is missing."""
        ...

    def check(self, surroundings: Surroundings) -> None:
        """Raise InputError for what it cannot show; called for all effects before any of them changes its state."""
        ...

    def drive(self, parameters: FloatArray, surroundings: Surroundings) -> Surroundings:
        """Change the parameters (p,), in place, before the muscles are evaluated; return what acts from outside."""
        ...

    def respond(
        self, parameters: FloatArray, coordinates: FloatArray, own: FloatArray, surroundings: Surroundings
    ) -> None:
        """Change the coordinates (lifts + modes,) of the face, and set its own (k,), in place."""
        ...

    def finish(
        self, coordinates: FloatArray, vertices: npt.NDArray[np.float32], folds: FloatArray | None = UNFOLDED
    ) -> None:
        """Change the vertices (n, 3), in place.

        folds (f, 3): places at rest, in metres, where tissue was folded until the guard has mended it; None where it
        was, but nobody knows where.
        """
        ...

    def restart(self) -> None:
        """Forget the frames before, in place, as fast as a frame: the next one is as the first."""
        ...

    def at(self, setting: Setting) -> Effect:
        """Return the effect for the leading modes of a setting, with a state of its own, at rest."""
        ...

    def within(self, part: Part) -> Effect:
        """Return the effect of a part of its model: fewer parameters, coordinates, carrying points and vertices."""
        ...

    def in_axes(self, order: tuple[int, int, int]) -> Effect:
        """Return the effect for vertices whose components are those of the model in another order."""
        ...

    def write(self, group: h5py.Group) -> None:
        """Store the effect in an HDF5 group."""
        ...

    @classmethod
    def read(cls, group: h5py.Group) -> Effect:
        """Load what `write` stored."""
        ...


def vector(values: npt.ArrayLike, what: str) -> FloatArray:
    """Return three finite numbers as an array; raises InputError for anything else."""
    try:
        result = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        result = np.empty(0)
    if result.shape != (3,) or not all(map(math.isfinite, result.tolist())):
        raise InputError(f"{what} {values!r}; give three finite numbers")
    return result
