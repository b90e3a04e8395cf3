"""Evaluators: from parameters (muscle activations, pose weights) to reduced coordinates.

A new evaluator is one file here with a class that satisfies `Evaluator`, and one line in `EVALUATORS`.
"""

from __future__ import annotations

from typing import Protocol

import h5py

from risorius.evaluators.polynomial import PolynomialMap
from risorius.evaluators.rational import RationalMap
from risorius.evaluators.superposition import Superposition
from risorius.jaw import FloatArray


class Evaluator(Protocol):
    """Maps parameters (p,) to modal coordinates (r,)."""

    name: str

    def coordinates(self, parameters: FloatArray, out: FloatArray) -> None:
        """Write the modal coordinates (r,) of parameters (p,) into `out`."""
        ...

    def write(self, group: h5py.Group) -> None:
        """Store the evaluator in an HDF5 group."""
        ...


EVALUATORS = {kind.name: kind for kind in (Superposition, PolynomialMap, RationalMap)}
LEARNED = (RationalMap.name, PolynomialMap.name)
"""Learned maps, the more accurate first."""
