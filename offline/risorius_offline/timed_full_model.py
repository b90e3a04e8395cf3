"""The full model by the clock, for the report of a reduced one: from rest, and going on from a reduced answer."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.anatomy import load_source
from risorius_offline.contact_choice import ContactChoice
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.equilibrium import EquilibriumSolver, NotConvergedError


class TimedFullModel:
    """The full model of an anatomy with the effects that the snapshots of a provenance were solved with.

    Making one compiles the kernels, so that no time holds set-up. Raises InputError when the source is not the anatomy
    of the snapshots.
    """

    def __init__(self, source: str, provenance: Mapping[str, Any]) -> None:
        anatomy = load_source(source)
        if anatomy.checksum() != provenance.get("anatomy"):
            raise InputError(f"{source}: is not the anatomy of the snapshots; give the one that they were solved with")
        self._solver = EquilibriumSolver(_effects(provenance).model(anatomy))
        parameters = np.zeros(len(anatomy.inputs.parameters))
        parameters[0] = 0.1
        self._solver.solve(parameters)

    def solve_seconds(self, parameters: FloatArray) -> FloatArray:
        """Seconds (k,) of solves from rest to parameters (k, p). Raises NotConvergedError as the solver does."""
        seconds = np.empty(len(parameters))
        for row, wanted in enumerate(parameters):
            begin = time.perf_counter()
            self._solver.solve(wanted)
            seconds[row] = time.perf_counter() - begin
        return seconds

    def way_from(self, guess: FloatArray, parameters: FloatArray) -> list[tuple[float, FloatArray]]:
        """Displacements (n, 3) on the way from a guess to an equilibrium at parameters (p,), each with seconds so far.

        way[k] took k tangents; the last is the equilibrium, or where the solver gave up.
        """
        begin = time.perf_counter()
        way = list[tuple[float, FloatArray]]()

        def passed(u: FloatArray) -> None:
            way.append((time.perf_counter() - begin, u.copy()))

        try:
            passed(replace(self._solver, watch=passed).settle(parameters, guess).u)
        except NotConvergedError:
            passed(way[-1][1] if way else guess)
        return way


def _effects(stored: Mapping[str, Any]) -> EffectChoice:
    gravity = stored["effect_gravity"]
    return EffectChoice(
        contact=ContactChoice(stored["effect_contact"]),
        gravity=tuple(gravity) if gravity else None,
        prestress=stored["effect_prestress"],
        force_length=stored["effect_force_length"],
    )
