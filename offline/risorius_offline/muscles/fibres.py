"""What a fibre construction gives: the tissue of a muscle, and the direction in which the muscle pulls there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import h5py
import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.discretisation import Discretisation, IntArray


@dataclass(frozen=True)
class FibreField:
    """points (k,): numbers of volume quadrature points, counted block by block, element by element, point by point.

    directions (k, 3): unit fibre tangents there, from the insertion to the origin, as the tau of (7.3).
    """

    points: IntArray
    directions: FloatArray


@dataclass(frozen=True)
class InsertionEnd:
    """Where a muscle ends in soft tissue: point (3,) in metres, unit direction (3,) out of the muscle, and the radius
    in metres of a circle as large as the muscle's section there.
    """

    point: FloatArray
    direction: FloatArray
    radius: float


class Fibres(Protocol):
    """A construction of virtual fibres. Its data classes are frozen, their lengths in metres."""

    kind: ClassVar[str]

    def field(self, discretisation: Discretisation) -> FibreField:
        """Tissue and directions; raises InputError where there is no tissue."""
        ...

    def length(self, discretisation: Discretisation) -> float:
        """Mean length of the fibres at rest, metres."""
        ...

    def insertion_end(self, discretisation: Discretisation) -> InsertionEnd:
        """The end that an insertion cone prolongs; raises InputError for a muscle without an insertion."""
        ...

    def write(self, group: h5py.Group) -> None:
        """Store the construction in an HDF5 group."""
        ...


def volume_positions(discretisation: Discretisation) -> FloatArray:
    """(p, 3) positions in metres of all volume quadrature points, in the order of `FibreField.points`."""
    return np.concatenate([block.positions.reshape(-1, 3) for block in discretisation.volumes])
