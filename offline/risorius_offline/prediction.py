"""Where the tissue may be at the end of a load step in which the bones move: what Newton's method starts from."""

from __future__ import annotations

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.full_model import FullModel
from risorius_offline.newton import SolverReport, factorise

# Largest displacement in a difference of forces that stands for their derivative, metres.
DIFFERENCE = 1e-8


def predicted(
    model: FullModel, u: FloatArray, before: FloatArray, after: FloatArray, report: SolverReport
) -> FloatArray:
    """Displacement (n, 3) after a step from an equilibrium u (n, 3), the bones where parameters `after` have them.

    Tissue follows as linear elasticity at rest would have it. Where that inverts cells it follows the tangent at u,
    for a factorisation more. If that inverts cells too, the step is too long. At the end parameters `after` act.
    """
    following = model.follow_bones(u, before, after)
    model.set_parameters(after)
    if np.isfinite(model.energy(following)):
        return following
    model.set_parameters(before)
    if factorise(model, u, 0, report) is not None:
        following = _along_the_tangent(model, u, following)
    model.set_parameters(after)
    return following


def _along_the_tangent(model: FullModel, u: FloatArray, following: FloatArray) -> FloatArray:
    """Prescribed components as in `following`, free ones so that forces stay as they are at u to first order."""
    direction = following - u
    step = DIFFERENCE / float(np.abs(direction).max())
    ahead, behind = (model.forces(u + sign * step * direction)[2] for sign in (1.0, -1.0))
    change = ((ahead - behind) / (2.0 * step)).reshape(-1)
    direction.reshape(-1)[model.free] -= model.solve(change[model.free])
    result = u + model.largest_step(u, direction) * direction
    result.reshape(-1)[model.prescribed] = following.reshape(-1)[model.prescribed]
    return result
