"""Evaluators: from parameters (muscle activations, pose weights) to reduced coordinates.

A new evaluator is one file here with a class that satisfies `Evaluator`, and one line in `EVALUATORS`.
"""

from __future__ import annotations

from typing import Protocol

import h5py

from risorius.evaluators.corrected import CorrectedMap
from risorius.evaluators.network import NetworkMap
from risorius.evaluators.polynomial import PolynomialMap
from risorius.evaluators.rational import RationalMap
from risorius.evaluators.setting import Setting
from risorius.evaluators.superposition import Superposition
from risorius.jaw import FloatArray
from risorius.part import Part


class Evaluator(Protocol):
    """Maps parameters (p,) to modal coordinates (r,).

    doubt: what it knows of its error after an answer, not negative, in units of a coordinate; 0 for nothing.
    """

    name: str
    doubt: float

    def coordinates(self, parameters: FloatArray, out: FloatArray) -> None:
        """Write the modal coordinates (r,) of parameters (p,) into `out`."""
        ...

    def at(self, setting: Setting) -> Evaluator:
        """Return the evaluator of the leading modes that runs as a setting has it."""
        ...

    def within(self, part: Part) -> Evaluator:
        """Return what gives the modes of a part of the model for its parameters."""
        ...

    def write(self, group: h5py.Group) -> None:
        """Store the evaluator in an HDF5 group."""
        ...


EVALUATORS = {kind.name: kind for kind in (Superposition, PolynomialMap, RationalMap, NetworkMap, CorrectedMap)}
