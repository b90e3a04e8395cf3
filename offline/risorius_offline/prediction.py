"""Where the tissue may be at the end of a load step in which the bones move: what Newton's method starts from."""

from __future__ import annotations

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.full_model import FullModel
from risorius_offline.newton import SolverReport, factorise

# Largest displacement in a difference of forces that stands for their derivative, metres.
DIFFERENCE = 1e-8


class Predictor:
    """Predicts displacements beside an equilibrium u (n, 3) at parameters (p,).

    Tissue follows the bones as linear elasticity at rest would have it. Where that inverts cells it follows the tangent
    at u, for one factorisation, which is kept: nothing else may be factorised while a predictor is in use.
    """

    def __init__(self, model: FullModel, u: FloatArray, parameters: FloatArray, report: SolverReport) -> None:
        self._model, self._u, self._parameters, self._report = model, u, parameters, report
        self._level: int | None = None
        self._factorised = False

    def predict(self, after: FloatArray) -> FloatArray | None:
        """Displacement (n, 3) with the bones where parameters `after` (p,) have them, which act from now on.

        None where cells would be inverted.
        """
        model = self._model
        model.set_parameters(self._parameters)
        following = model.follow_bones(self._u, self._parameters, after)
        if self._admissible(following, after):
            return following
        model.set_parameters(self._parameters)
        if not self._factorised:
            self._level, self._factorised = factorise(model, self._u, 0, self._report), True
        if self._level is None:
            return None
        following = self._along_the_tangent(following)
        return following if self._admissible(following, after) else None

    def _admissible(self, u: FloatArray, parameters: FloatArray) -> bool:
        self._model.set_parameters(parameters)
        return bool(np.isfinite(self._model.energy(u)))

    def _along_the_tangent(self, following: FloatArray) -> FloatArray:
        """Prescribed components as in `following`, free ones so that forces stay as they are to first order."""
        model, u = self._model, self._u
        direction = following - u
        step = DIFFERENCE / max(float(np.abs(direction).max()), np.finfo(float).tiny)
        ahead, behind = (model.forces(u + sign * step * direction)[2] for sign in (1.0, -1.0))
        change = ((ahead - behind) / (2.0 * step)).reshape(-1)
        direction.reshape(-1)[model.free] -= model.solve(change[model.free])
        result = u + model.largest_step(u, direction) * direction
        result.reshape(-1)[model.prescribed] = following.reshape(-1)[model.prescribed]
        return result
