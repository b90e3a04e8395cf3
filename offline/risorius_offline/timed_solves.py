"""Solves of the full model by the clock, for the report of a reduced model."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.anatomy import load_source
from risorius_offline.contact_choice import ContactChoice
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.equilibrium import EquilibriumSolver


def timed_solves(source: str, provenance: Mapping[str, Any], parameters: FloatArray) -> FloatArray:
    """Seconds (k,) of solves from rest to parameters (k, p), as the snapshots of this provenance were solved.

    Set-up is not counted. Raises InputError when the source is not the anatomy of the snapshots, NotConvergedError as
    the solver does.
    """
    anatomy = load_source(source)
    if anatomy.checksum() != provenance.get("anatomy"):
        raise InputError(f"{source}: is not the anatomy of the snapshots; give the one that they were solved with")
    solver = EquilibriumSolver(_effects(provenance).model(anatomy))
    solver.solve(0.1 * parameters[0])  # compiles the kernels
    seconds = np.empty(len(parameters))
    for row, wanted in enumerate(parameters):
        begin = time.perf_counter()
        solver.solve(wanted)
        seconds[row] = time.perf_counter() - begin
    return seconds


def _effects(stored: Mapping[str, Any]) -> EffectChoice:
    gravity = stored["effect_gravity"]
    return EffectChoice(
        contact=ContactChoice(stored["effect_contact"]),
        gravity=tuple(gravity) if gravity else None,
        prestress=stored["effect_prestress"],
        force_length=stored["effect_force_length"],
    )
