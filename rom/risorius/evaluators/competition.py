"""Competition: what a muscle achieves falls with its own activation and with that of muscles on the same tissue.

Active stress stiffens tissue in the direction in which it pulls, so displacements saturate jointly. In place of the
parameters p the learned map uses

    b_i = p_i / (1 + sum_k c_ki p_k),    c_ki >= 0 between muscles,

which is exact for a spring pulled by muscles whose forces fall linearly as they shorten. The weights c (p, p) are those
with which the b, combined linearly, best follow the snapshots and their derivatives: separable least squares (Golub and
Pereyra 1973), the linear part eliminated, c by L-BFGS-B. Only muscles are divided, by all parameters that cannot be
negative.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numba
import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize

from risorius.evaluators.observations import Observations
from risorius.jaw import FloatArray

LEADING_MODES = 60
MOST_SNAPSHOTS = 400
DERIVATIVE_WEIGHT = 0.3
# Penalties on squares of the weights, and of the coefficients of b, in parts of the sum of squares of the targets.
DECAY = 5e-5
LINEAR_DECAY = 1e-7
START = 0.5  # weight of a muscle on itself
RELIEF = -0.5  # poses may also help a muscle, all together by so much: no denominator is less than 1/2
STEPS = 80


def fit_competition(observations: Observations) -> FloatArray:
    """Weights (p, p): [k, i] is what one unit of parameter k adds to the denominator of parameter i."""
    observations = observations.thinned(MOST_SNAPSHOTS).both_sides()
    count, muscles = observations.parameters.shape[1], observations.muscles
    admissible = AdmissibleWeights.of(observations)
    free, least = admissible.free, admissible.least
    if not free.any():
        return np.zeros((count, count))
    start = np.diag(np.where(np.arange(count) < muscles, START, 0.0))
    problem = _Fit(observations, LEADING_MODES)
    decay = DECAY * problem.size

    def objective(values: FloatArray) -> tuple[float, FloatArray]:
        weights = np.zeros((count, count))
        weights[free] = values
        loss, gradient = problem.loss(weights)
        return loss + 0.5 * decay * float(values @ values), gradient[free] + decay * values

    bounds = [(low, None) for low in least[free]]
    found = minimize(objective, start[free], jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": STEPS})
    weights = np.zeros((count, count))
    weights[free] = found.x
    return observations.symmetrised(weights)


@dataclass(frozen=True)
class AdmissibleWeights:
    """free (p, p): weights that may differ from 0; least (p, p) of these, so that no denominator is less than 1/2."""

    free: npt.NDArray[np.bool_]
    least: FloatArray

    @classmethod
    def of(cls, observations: Observations) -> AdmissibleWeights:
        """Those of muscles divided by parameters that cannot be negative."""
        count, muscles = observations.parameters.shape[1], observations.muscles
        rivals = observations.lowest >= 0.0
        free = np.zeros((count, count), bool)
        free[:, :muscles] = rivals[:, None]
        relief = RELIEF / max(int(rivals[muscles:].sum()), 1)
        least = np.where(np.arange(count) < muscles, 0.0, relief)[:, None].repeat(count, axis=1)
        return cls(free, least)

    def nearest(self, weights: FloatArray) -> FloatArray:
        """The admissible weights nearest to some (p, p)."""
        return np.where(self.free, np.maximum(weights, self.least), 0.0)


@dataclass(frozen=True)
class _Fit:
    """Least squares of the leading modes by b: half the sum of squares, and its gradient by the weights."""

    observations: Observations
    modes: int

    @cached_property
    def _targets(self) -> tuple[FloatArray, FloatArray]:
        """Values (s, r) and, weighted, derivatives (s, p, r); (s, 0, r) where there are none."""
        values = self.observations.coordinates[:, : self.modes]
        derivatives = self.observations.derivatives
        if derivatives is None:
            return values, np.zeros((len(values), 0, values.shape[1]))
        return values, DERIVATIVE_WEIGHT * derivatives[:, :, : self.modes].astype(np.float64)

    @cached_property
    def size(self) -> float:
        """Sum of the squares of all targets."""
        return float(sum((targets**2).sum() for targets in self._targets))

    def loss(self, weights: FloatArray) -> tuple[float, FloatArray]:
        p = self.observations.parameters
        values, derivatives = self._targets
        count, step = p.shape[1], DERIVATIVE_WEIGHT if derivatives.shape[1] else 0.0
        inverse = 1.0 / (1.0 + p @ weights)
        b, slope = p * inverse, p * inverse**2
        # [s, j, i] of d b_i / d p_j
        jacobian = step * (inverse[:, None] * np.eye(count) - slope[:, None] * weights)[:, : derivatives.shape[1]]
        flat, targets = jacobian.reshape(-1, count), derivatives.reshape(-1, values.shape[1])
        normal = b.T @ b + flat.T @ flat + LINEAR_DECAY * self.size * np.eye(count)
        linear = np.linalg.solve(normal, b.T @ values + flat.T @ targets)
        misfit, misfit_slope = b @ linear - values, flat @ linear - targets
        loss = 0.5 * (np.vdot(misfit, misfit) + np.vdot(misfit_slope, misfit_slope))
        loss += 0.5 * LINEAR_DECAY * self.size * np.vdot(linear, linear)
        by_b = misfit @ linear.T
        by_jacobian = step * (misfit_slope @ linear.T).reshape(jacobian.shape)
        own = np.zeros_like(p) if not step else np.einsum("sii->si", by_jacobian)
        by_denominator = -by_b * slope - own * inverse**2
        by_denominator += 2.0 * slope * inverse * np.einsum("sji,ji->si", by_jacobian, weights[: jacobian.shape[1]])
        gradient = p.T @ by_denominator
        gradient[: jacobian.shape[1]] -= np.einsum("sji,si->ji", by_jacobian, slope)
        return float(loss), gradient


@numba.njit(cache=True)
def compete(parameters, weights, out):  # type: ignore[no-untyped-def]
    """Write b (p,) of parameters (p,)."""
    out[:] = 1.0
    for k in range(len(parameters)):
        value = parameters[k]
        if value != 0.0:
            for i in range(len(out)):
                out[i] += value * weights[k, i]
    for i in range(len(out)):
        out[i] = parameters[i] / out[i]


@numba.njit(cache=True)
def compete_slopes(parameters, weights, values, slopes):  # type: ignore[no-untyped-def]
    """Write b (p,), and its derivatives: slopes[i, j] = d b_i / d p_j."""
    compete(parameters, weights, values)
    for i in range(len(values)):
        denominator = 1.0
        for k in range(len(parameters)):
            denominator += parameters[k] * weights[k, i]
        for j in range(len(parameters)):
            slopes[i, j] = -values[i] / denominator * weights[j, i]
        slopes[i, i] += 1.0 / denominator
