"""Derivatives of an equilibrium by its parameters and by gravity, from the factorised tangent.

With f(u, p) = 0 on the free components, K du/dp = -df/dp, where df/dp holds the free components and lets the bones
and lids follow the pose.
"""

from __future__ import annotations

import numpy as np

from risorius.errors import SolverError
from risorius.jaw import FloatArray
from risorius.mechanics.material import TISSUE_DENSITY
from risorius_offline.equilibrium import Equilibrium
from risorius_offline.full_model import FullModel
from risorius_offline.linear_solver import NotPositiveDefiniteError

# Central differences of forces by pose weights: truncation and rounding are both near 1e-9, relative.
POSE_STEP = 1e-5


def sensitivities(model: FullModel, equilibrium: Equilibrium) -> FloatArray:
    """du/dp (p, n, 3) in metres per unit weight, at one solve with p right-hand sides.

    It takes a factorisation where the model has another one's factors than that of the equilibrium.
    Raises SolverError when the tangent is not positive definite there: the equilibrium is not stable.
    """
    parameters, u = equilibrium.parameters, equilibrium.u
    _factorise(model, equilibrium)
    result = np.zeros((len(parameters), *u.shape))
    forces = np.empty((len(parameters), u.size))
    forces[: model.muscle_count] = model.muscle_forces(u).T
    for number in range(model.muscle_count, len(parameters)):
        result[number], forces[number] = _by_pose_weight(model, parameters, number, u)
    model.set_parameters(parameters)
    flat = result.reshape(len(parameters), -1)
    flat[:, model.free] = -model.solve(np.ascontiguousarray(forces[:, model.free].T)).T
    return result


def gravity_sensitivities(model: FullModel, equilibrium: Equilibrium) -> FloatArray:
    """du/dg (3, n, 3) in metres per m/s2 of gravity along x, y and z, at one solve with three right-hand sides.

    Factors and errors are as in `sensitivities`.
    """
    _factorise(model, equilibrium)
    weights = np.zeros((len(equilibrium.u), 3, 3))
    weights[:, range(3), range(3)] = TISSUE_DENSITY * model.discretisation.consistent_volumes[:, None]
    result = np.zeros((3, equilibrium.u.size))
    result[:, model.free] = model.solve(np.ascontiguousarray(weights.reshape(-1, 3)[model.free])).T
    return result.reshape(3, -1, 3)


def _factorise(model: FullModel, equilibrium: Equilibrium) -> None:
    """Have the model hold the factors of the tangent at an equilibrium, and act with its parameters."""
    model.set_parameters(equilibrium.parameters)
    if model.factorised_for is equilibrium:
        return
    model.hold_contacts(model.search_contacts(equilibrium.u, equilibrium.contacts))
    try:
        model.factorise(*model.tangent(equilibrium.u))
    except NotPositiveDefiniteError as error:
        raise SolverError("the equilibrium is not stable: its tangent is not positive definite") from error
    model.factorised_for = equilibrium


def _by_pose_weight(
    model: FullModel, parameters: FloatArray, number: int, u: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Motion (n, 3) of bones and lids per unit weight, and df/dw (3 n,) along it."""
    states = [_moved(parameters, number, sign * POSE_STEP) for sign in (1.0, -1.0)]
    displaced = [np.where(model.anatomy.prescribed[:, None], model.prescribed_motion(state), u) for state in states]
    plus, minus = (_forces(model, state, moved) for state, moved in zip(states, displaced, strict=True))
    return (displaced[0] - displaced[1]) / (2 * POSE_STEP), ((plus - minus) / (2 * POSE_STEP)).ravel()


def _forces(model: FullModel, parameters: FloatArray, u: FloatArray) -> FloatArray:
    model.set_parameters(parameters)
    return model.forces(u)[2]


def _moved(parameters: FloatArray, number: int, step: float) -> FloatArray:
    result = parameters.copy()
    result[number] += step
    return result
