"""Training of the network map: values and derivatives of snapshots, by Adam (Kingma and Ba 2015).

Each step looks at a few snapshots (`network_gradient`). Weights of the competition are trained with the others. Members
know nothing of each other, and are trained side by side.

What muscles do together is much the same on a coarser mesh of a face, whose snapshots are cheap. So a network may begin
from one of such a mesh: its layers are taken over, coefficients of the modes found by ridge regression on what these
layers make of the snapshots, and all weights then trained for a while, in small steps.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import chain, repeat

import numba
import numpy as np

from risorius.errors import InputError
from risorius.evaluators.competition import AdmissibleWeights, fit_competition
from risorius.evaluators.network import COMBINED, Member, NetworkMap
from risorius.evaluators.network_gradient import DECAY, PARTS, Arrays, NetworkGradient, views
from risorius.evaluators.observations import Observations, Reflection
from risorius.jaw import FloatArray
from risorius.training_stages import UNTOLD

Reached = Callable[[float], None]

MEMBERS = 2
STEPS_EACH, MOST_STEPS = 16, 14_000  # steps for each snapshot
STEPS_OF_FEW, ENOUGH_OF_FEW = 2 * STEPS_EACH, 4_000  # where snapshots are few, twice as many up to so many
RATE, LAST_RATE = 4e-3, 1e-6  # of Adam; it falls along a cosine
MOMENTS = (0.9, 0.99)
STEPS_AFTER, RATE_AFTER = 4, 1e-3  # of one that begins from another
BATCHES = 80  # that coefficients are found from
TOLD_EVERY = 20  # steps
FIRST_THRESHOLDS, FIRST_COEFFICIENTS = 0.05, 0.01


def fit_network(
    observations: Observations, coarse: NetworkMap | None = None, reached: Reached = UNTOLD.reached
) -> NetworkMap:
    """Train a committee on snapshots with derivatives, from the start or from the layers of a coarser mesh's.

    reached: is told what share of it is done.
    Raises InputError where snapshots have no derivatives, or `coarse` is of another kind of face.
    """
    if observations.derivatives is None:
        raise InputError("snapshots: have no derivatives, which a network is trained with; solve them with derivatives")
    count = observations.parameters.shape[1]
    reflection = observations.reflection or Reflection(
        np.arange(count), np.ones(count), np.ones(observations.coordinates.shape[1])
    )
    if coarse is not None and not np.array_equal(coarse.reflection.partner, reflection.partner):
        raise InputError("coarse: one face is its own mirror image and the other is not; give meshes of the same face")
    problems = [NetworkGradient(observations, reflection) for _ in range(MEMBERS)]  # each has room of its own
    train, starts = (
        (_trained, repeat(fit_competition(observations))) if coarse is None else (_continued, coarse.members)
    )
    with ThreadPoolExecutor(MEMBERS) as pool:
        members = tuple(pool.map(train, problems, starts, range(MEMBERS), chain([reached], repeat(UNTOLD.reached))))
    return NetworkMap(members, reflection, np.arange(count))


def _steps(snapshots: int) -> int:
    """Number of steps for so many snapshots."""
    of_few = min(STEPS_OF_FEW * snapshots, ENOUGH_OF_FEW)
    return min(max(STEPS_EACH * snapshots, of_few), MOST_STEPS)


def _trained(problem: NetworkGradient, competition: FloatArray, seed: int, reached: Reached) -> Member:
    rng = np.random.default_rng(seed)
    start = _first(problem.observations, competition, problem.shapes, rng)
    return _descended(problem, start, RATE, _steps(len(problem.observations.parameters)), rng, reached)


def _continued(problem: NetworkGradient, member: Member, seed: int, reached: Reached) -> Member:
    rng = np.random.default_rng(seed)
    steps = min(STEPS_AFTER * len(problem.observations.parameters), MOST_STEPS)
    return _descended(problem, _taken_over(problem, member, rng), RATE_AFTER, steps, rng, reached)


def _descended(
    problem: NetworkGradient, start: Arrays, rate: float, steps: int, rng: np.random.Generator, reached: Reached
) -> Member:
    """Weights after so many steps, the first of which are of length `rate`."""
    observations, shapes = problem.observations, problem.shapes
    admissible = AdmissibleWeights.of(observations)
    theta = np.concatenate([one.ravel() for one in start.values()])
    mean, square, gradient = np.zeros_like(theta), np.zeros_like(theta), np.empty_like(theta)
    now, slopes = views(theta, shapes), views(gradient, shapes)
    for step in range(1, steps + 1):
        problem.at(now, *problem.draw(rng), slopes)
        length = LAST_RATE + 0.5 * rate * (1.0 + np.cos(np.pi * step / steps))
        _adam(gradient, length, step, mean, square, theta)
        doubled = observations.symmetrised(now["competition"].astype(np.float64))
        now["competition"][:] = admissible.nearest(doubled)
        if step % TOLD_EVERY == 0:
            reached(step / steps)
    competition = now.pop("competition").astype(np.float64)
    return Member.of(competition, **now)


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

    start = {"competition": competition, "first": combinations(count)}
    start |= {f"second_{name}": combinations(count + neurons) for name in PARTS}
    spread = {"thresholds": FIRST_THRESHOLDS, "even": FIRST_COEFFICIENTS, "odd": FIRST_COEFFICIENTS}
    for name, shape in shapes.items():
        if name not in start:
            start[name] = spread[name.split("_")[-1]] * rng.normal(size=shape)
    return {name: start[name].astype(np.float32) for name in shapes}


def _taken_over(problem: NetworkGradient, member: Member, rng: np.random.Generator) -> Arrays:
    """Layers of a member, and the coefficients that suit these snapshots best."""
    start = {name: np.zeros(shape, np.float32) for name, shape in problem.shapes.items()}
    for name in start.keys() - set(PARTS):
        known = getattr(member, name)
        start[name][:] = known.values if name in COMBINED else known
    sums = {name: (np.zeros((len(start[name]),) * 2), np.zeros(start[name].shape)) for name in PARTS}
    for _ in range(BATCHES):
        for name, batch in problem.normal_equations(start, *problem.draw(rng)).items():
            for total, part in zip(sums[name], batch, strict=True):
                total += part / BATCHES
    for name, (square, product) in sums.items():
        start[name][:] = np.linalg.solve(square + DECAY * np.eye(len(square)), product)
    return start
