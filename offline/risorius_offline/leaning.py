"""Equilibria of a face at rest whose head leans."""

from __future__ import annotations

from copy import copy

import numpy as np

from risorius.effects.leaning import LEANING
from risorius.jaw import FloatArray
from risorius_offline.effects.gravity import UPRIGHT, gravity
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel

# Of the forces: moves no node by a thousandth of what weight does, in two thirds of the time.
TOLERANCE = 1e-4


def leaning_at_rest(model: FullModel) -> FloatArray:
    """Displacement (5, n, 3), metres, of a model at rest, in each pose of LEANING.

    Contact works one way, and no tangent at rest, where tissue lies on bones without pressing, knows of it. Raises
    NotConvergedError where there is no equilibrium.
    """
    at_rest = np.zeros(len(model.anatomy.inputs.parameters))
    weighed = copy(model)  # on the same matrices
    found = []
    for pose in LEANING:
        weighed.effects = (*model.effects, gravity(model.discretisation, pose, UPRIGHT))
        found.append(EquilibriumSolver(weighed, TOLERANCE).solve(at_rest).u)
    model.factorised_for = None  # the factors that they share are of another state now
    return np.array(found)
