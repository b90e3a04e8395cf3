"""Training of the network map: values and derivatives of snapshots, by Adam (Kingma and Ba 2015).

Each step looks at a few snapshots (`network_gradient`). Weights of the competition are trained with the others. Members
know nothing of each other, and are trained side by side.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from itertools import repeat

import numba
import numpy as np
from threadpoolctl import threadpool_limits

from risorius.errors import InputError
from risorius.evaluators.competition import AdmissibleWeights, fit_competition
from risorius.evaluators.network import Member, NetworkMap
from risorius.evaluators.network_gradient import Arrays, NetworkGradient, views
from risorius.evaluators.observations import Observations, Reflection
from risorius.jaw import FloatArray

MEMBERS = 2
STEPS_EACH, MOST_STEPS = 16, 14_000  # steps for each snapshot
STEPS_OF_FEW, ENOUGH_OF_FEW = 2 * STEPS_EACH, 4_000  # where snapshots are few, twice as many up to so many
RATE, LAST_RATE = 4e-3, 1e-6  # of Adam; it falls along a cosine
MOMENTS = (0.9, 0.99)
FIRST_THRESHOLDS, FIRST_COEFFICIENTS = 0.05, 0.01


def fit_network(observations: Observations) -> NetworkMap:
    """Train a committee on snapshots with derivatives; raises InputError where they have none."""
    if observations.derivatives is None:
        raise InputError("snapshots: have no derivatives, which a network is trained with; solve them with derivatives")
    count = observations.parameters.shape[1]
    reflection = observations.reflection or Reflection(
        np.arange(count), np.ones(count), np.ones(observations.coordinates.shape[1])
    )
    problems = [NetworkGradient(observations, reflection) for _ in range(MEMBERS)]  # each has room of its own
    competition = fit_competition(observations)
    # Products are small: threads of one that wait for each other take four times the CPU time.
    with threadpool_limits(1), ThreadPoolExecutor(MEMBERS) as pool:
        members = tuple(pool.map(_trained, problems, repeat(competition), range(MEMBERS)))
    return NetworkMap(members, reflection, np.arange(count))


def _steps(snapshots: int) -> int:
    """Number of steps for so many snapshots."""
    of_few = min(STEPS_OF_FEW * snapshots, ENOUGH_OF_FEW)
    return min(max(STEPS_EACH * snapshots, of_few), MOST_STEPS)


def _trained(problem: NetworkGradient, competition: FloatArray, seed: int) -> Member:
    rng, observations, shapes = np.random.default_rng(seed), problem.observations, problem.shapes
    admissible = AdmissibleWeights.of(observations)
    theta = np.concatenate([one.ravel() for one in _first(observations, competition, shapes, rng).values()])
    mean, square, gradient = np.zeros_like(theta), np.zeros_like(theta), np.empty_like(theta)
    steps = _steps(len(observations.parameters))
    now, slopes = views(theta, shapes), views(gradient, shapes)
    for step in range(1, steps + 1):
        problem.at(now, *problem.draw(rng), slopes)
        rate = LAST_RATE + 0.5 * RATE * (1.0 + np.cos(np.pi * step / steps))
        _adam(gradient, rate, step, mean, square, theta)
        doubled = observations.symmetrised(now["competition"].astype(np.float64))
        now["competition"][:] = admissible.nearest(doubled)
    competition = now.pop("competition").astype(np.float64)
    return Member(competition, **{name: array.copy() for name, array in now.items()}).rounded()


@numba.njit(cache=True, nogil=True)
def _adam(gradient, rate, step, mean, square, theta):  # type: ignore[no-untyped-def]
    """Take a step."""
    first, second = np.float32(MOMENTS[0]), np.float32(MOMENTS[1])
    length = np.float32(rate / (1.0 - MOMENTS[0] ** step))
    unbiased = np.float32(1.0 / (1.0 - MOMENTS[1] ** step))
    one, least = np.float32(1.0), np.float32(1e-8)
    for i in range(len(theta)):
        mean[i] += (one - first) * (gradient[i] - mean[i])
        square[i] += (one - second) * (gradient[i] * gradient[i] - square[i])
        theta[i] -= length * mean[i] / (np.sqrt(square[i] * unbiased) + least)


def _first(
    observations: Observations, competition: FloatArray, shapes: dict[str, tuple[int, ...]], rng: np.random.Generator
) -> Arrays:
    """Where training starts: random combinations, of length 1, of parameters that move the same tissue."""
    overlap = observations.symmetrised(observations.overlap)
    count, neurons = len(overlap), shapes["first_thresholds"][0]

    def combinations(inputs: int) -> FloatArray:
        local = rng.normal(size=(count, neurons)) * overlap[:, rng.integers(0, count, neurons)]
        others = rng.normal(size=(inputs - count, neurons)) / np.sqrt(max(inputs - count, 1))
        both = np.vstack([local, others])
        return np.asarray(both / np.linalg.norm(both, axis=0))

    start = {"competition": competition, "first": combinations(count), "second": combinations(shapes["second"][0])}
    spread = {"thresholds": FIRST_THRESHOLDS, "even": FIRST_COEFFICIENTS, "odd": FIRST_COEFFICIENTS}
    for name, shape in shapes.items():
        if name not in start:
            start[name] = spread[name.split("_")[-1]] * rng.normal(size=shape)
    return {name: start[name].astype(np.float32) for name in shapes}
