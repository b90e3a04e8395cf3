"""Kinks: what tissue does in contact changes its slope where the contact opens or closes.

Lips that part are pulled by their own muscles only; lips that press move together. Products of smooth variables follow
that slowly. So combinations d = sum_i w_i b_i of the competing variables b are bent,

    sqrt(d^2 + WIDTH^2) - WIDTH,

which is |d| but for a rounded corner: one layer of neurons. Their weights w (p, h) are those with which b and kinks,
combined linearly, best follow the snapshots and their derivatives: separable least squares (Golub and Pereyra 1973), as
for the competition, by L-BFGS from random combinations of muscles that move the same tissue.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numba
import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize

from risorius.evaluators.competition import compete_slopes
from risorius.evaluators.observations import Observations
from risorius.jaw import FloatArray

EACH = 2  # kinks for each parameter, before their mirror images
WIDTH = 0.05
LEADING_MODES = 60
MOST_SNAPSHOTS = 400
DERIVATIVE_WEIGHT = 0.1
# Penalties on squares of the weights, and of the linear coefficients, in parts of the sum of squares of the targets.
DECAY = 1e-6
LINEAR_DECAY = 1e-6
STEPS = 100


def fit_kinks(observations: Observations, competition: FloatArray) -> FloatArray:
    """Weights (p, h): [i, k] is that of variable b_i in kink k.

    There are none (h = 0) without derivatives: values alone tell too little. On a symmetric face the second half are
    mirror images of the first.
    """
    count = len(competition)
    if observations.derivatives is None:
        return np.zeros((count, 0))
    problem = KinkFit.of(observations.thinned(MOST_SNAPSHOTS).both_sides(), competition)
    start = _first(observations)
    decay = DECAY * problem.size

    def objective(values: FloatArray) -> tuple[float, FloatArray]:
        loss, gradient = problem.loss(values.reshape(start.shape))
        return loss + 0.5 * decay * float(values @ values), gradient.ravel() + decay * values

    found = minimize(objective, start.ravel(), jac=True, method="L-BFGS-B", options={"maxiter": STEPS})
    weights: FloatArray = found.x.reshape(start.shape)
    reflection = observations.reflection
    if reflection is None:
        return weights
    return np.hstack([weights, weights[reflection.partner] * reflection.sign[:, None]])


def _first(observations: Observations) -> FloatArray:
    """Random combinations (p, h), of length 1, of parameters that overlap with a random one."""
    overlap = observations.symmetrised(observations.overlap)
    rng = np.random.default_rng(0)
    count = len(overlap)
    weights = rng.normal(size=(count, EACH * count)) * overlap[:, rng.integers(0, count, EACH * count)]
    return np.asarray(weights / np.linalg.norm(weights, axis=0))


@dataclass(frozen=True)
class KinkFit:
    """Least squares of the leading modes by b and kinks: half the sum of squares, and its gradient by the weights.

    variables b (s, p) of the snapshots and slopes [s, j, i] = DERIVATIVE_WEIGHT d b_i / d p_j; values (s, r) of the
    modes and derivatives (s p, r), weighted alike. What belongs to derivatives is single precision.
    """

    variables: FloatArray
    slopes: npt.NDArray[np.float32]
    values: FloatArray
    derivatives: npt.NDArray[np.float32]

    @classmethod
    def of(cls, observations: Observations, competition: FloatArray) -> KinkFit:
        """That of snapshots with derivatives."""
        count = len(competition)
        variables = np.empty_like(observations.parameters)
        slopes = np.empty((len(variables), count, count), np.float32)
        slope = np.empty((count, count))
        for parameters, out, turned in zip(observations.parameters, variables, slopes, strict=True):
            compete_slopes(parameters, competition, out, slope)
            turned[:] = DERIVATIVE_WEIGHT * slope.T
        derivatives = np.asarray(observations.derivatives)[:, :, :LEADING_MODES]
        return cls(
            variables,
            slopes,
            observations.coordinates[:, :LEADING_MODES],
            np.float32(DERIVATIVE_WEIGHT) * derivatives.reshape(-1, derivatives.shape[2]),
        )

    @cached_property
    def size(self) -> float:
        """Sum of the squares of all targets."""
        return float((self.values**2).sum() + (self.derivatives.astype(np.float64) ** 2).sum())

    def loss(self, weights: FloatArray) -> tuple[float, FloatArray]:
        """Half the sum of squares for weights (p, h), the linear part eliminated, and its gradient (p, h)."""
        samples, count, kinks = *self.variables.shape, weights.shape[1]
        flat, single = self.slopes.reshape(-1, count), weights.astype(np.float32)
        bent, slope, bend = _bent(self.variables @ weights)
        inner = (flat @ single).reshape(samples, count, kinks)
        features = np.hstack([self.variables, bent])
        steps = np.concatenate([self.slopes, inner * slope[:, None].astype(np.float32)], axis=2).reshape(len(flat), -1)
        normal = features.T @ features + steps.T @ steps + LINEAR_DECAY * self.size * np.eye(count + kinks)
        linear = np.linalg.solve(normal, features.T @ self.values + steps.T @ self.derivatives)
        misfit = features @ linear - self.values
        misfit_steps = steps @ linear.astype(np.float32) - self.derivatives
        loss = 0.5 * (np.vdot(misfit, misfit) + float(np.vdot(misfit_steps, misfit_steps)))
        loss += 0.5 * LINEAR_DECAY * self.size * np.vdot(linear, linear)
        of_kinks = linear[count:].T
        by_inner = (misfit_steps @ of_kinks.astype(np.float32)).reshape(inner.shape)
        by_combination = misfit @ of_kinks * slope + bend * np.einsum("sjk,sjk->sk", by_inner, inner)
        by_inner *= slope[:, None].astype(np.float32)
        return float(loss), self.variables.T @ by_combination + flat.T @ by_inner.reshape(len(flat), kinks)


def _bent(combinations: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Kinks of combinations d, their first and their second derivative by d."""
    root = np.sqrt(combinations**2 + WIDTH**2)
    return combinations**2 / (root + WIDTH), combinations / root, WIDTH**2 / root**3


@numba.njit(cache=True)
def bend(variables, weights, out):  # type: ignore[no-untyped-def]
    """Write the kinks (h,) of variables (p,)."""
    out[:] = 0.0
    for i in range(len(variables)):
        value = variables[i]
        if value != 0.0:
            for k in range(len(out)):
                out[k] += value * weights[i, k]
    for k in range(len(out)):
        square = out[k] * out[k]
        out[k] = square / (np.sqrt(square + WIDTH * WIDTH) + WIDTH)


def bend_slopes(variables: FloatArray, slopes: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Kinks (h,) of variables (p,) and their derivatives (h, j), from those of the variables, slopes (p, j)."""
    bent, slope, _ = _bent(variables @ weights)
    return bent, slope[:, None] * (weights.T @ slopes)
