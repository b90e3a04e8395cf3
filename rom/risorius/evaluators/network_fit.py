"""Training of the network map: values and derivatives of snapshots, by Adam (Kingma and Ba 2015).

A step looks at a few snapshots, and at their derivatives in a few random directions (Czarnecki et al. 2017, Sobolev
training), for which it runs the network and its derivatives forward and their squared errors back. Directions are 1 or
-1 in every parameter: the mean of the squared derivatives is then the sum of those by all parameters (Hutchinson 1990).
Weights of the competition are trained with the others.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from risorius.errors import InputError
from risorius.evaluators.competition import AdmissibleWeights, fit_competition
from risorius.evaluators.network import WIDTH, Member, NetworkMap, Single
from risorius.evaluators.observations import Observations, Reflection
from risorius.jaw import FloatArray

MEMBERS = 2
NEURONS_EACH, MOST_NEURONS = 4, 128  # neurons of each of the two layers, for each parameter
BATCH, DIRECTIONS = 64, 6  # snapshots and derivatives of each in a step
STEPS_EACH, MOST_STEPS = 25, 14_000  # steps for each snapshot
RATE, LAST_RATE = 8e-3, 1e-6  # of Adam; it falls along a cosine
MOMENTS = (0.9, 0.99)
DERIVATIVE_WEIGHT = 0.1
DECAY = 1e-4  # penalty on the squares of all weights but thresholds and competition
FIRST_THRESHOLDS, FIRST_COEFFICIENTS = 0.05, 0.01

Arrays = dict[str, Single]


def fit_network(observations: Observations) -> NetworkMap:
    """Train a committee on snapshots with derivatives; raises InputError where they have none."""
    if observations.derivatives is None:
        raise InputError("snapshots: have no derivatives, which a network is trained with; solve them with derivatives")
    count = observations.parameters.shape[1]
    reflection = observations.reflection or Reflection(
        np.arange(count), np.ones(count), np.ones(observations.coordinates.shape[1])
    )
    competition = fit_competition(observations)
    members = tuple(_trained(observations, reflection, competition, seed) for seed in range(MEMBERS))
    return NetworkMap(members, reflection, np.arange(count))


def _trained(observations: Observations, reflection: Reflection, competition: FloatArray, seed: int) -> Member:
    rng = np.random.default_rng(seed)
    problem = NetworkFit(observations, reflection)
    shapes, admissible = problem.shapes(), AdmissibleWeights.of(observations)
    theta = np.concatenate([one.ravel() for one in _first(observations, competition, shapes, rng).values()])
    mean, square, gradient = np.zeros_like(theta), np.zeros_like(theta), np.empty_like(theta)
    steps = min(STEPS_EACH * len(observations.parameters), MOST_STEPS)
    now = views(theta, shapes)
    for step in range(1, steps + 1):
        problem.gradient(now, *problem.draw(rng), views(gradient, shapes))
        mean += (1.0 - MOMENTS[0]) * (gradient - mean)
        square += (1.0 - MOMENTS[1]) * (gradient**2 - square)
        rate = LAST_RATE + 0.5 * RATE * (1.0 + np.cos(np.pi * step / steps))
        size = np.sqrt(square / (1.0 - MOMENTS[1] ** step)) + 1e-8
        theta -= np.float32(rate / (1.0 - MOMENTS[0] ** step)) * mean / size
        doubled = observations.symmetrised(now["competition"].astype(np.float64))
        now["competition"][:] = admissible.nearest(doubled)
    competition = now.pop("competition").astype(np.float64)
    return Member(competition, **{name: array.copy() for name, array in now.items()}).rounded()


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


def views(flat: Single, shapes: dict[str, tuple[int, ...]]) -> Arrays:
    """Parts of a flat array, by name, as arrays of their shapes."""
    ends = np.cumsum([math.prod(shape) for shape in shapes.values()])
    parts = np.split(flat, ends[:-1])
    return {name: part.reshape(shape) for (name, shape), part in zip(shapes.items(), parts, strict=True)}


@dataclass(frozen=True)
class NetworkFit:
    """Least squares of values and derivatives of snapshots by a network, and its gradient by the weights."""

    observations: Observations
    reflection: Reflection

    def shapes(self) -> dict[str, tuple[int, ...]]:
        """Of each array of a `Member`."""
        count = len(self.reflection.partner)
        neurons = min(NEURONS_EACH * count, MOST_NEURONS)
        even = int((self.reflection.parity > 0.0).sum())
        features = count + 2 * neurons
        return {
            "competition": (count, count),
            "first": (count, neurons),
            "first_thresholds": (neurons,),
            "second": (features, neurons),
            "second_thresholds": (neurons,),
            "even": (features, even),
            "odd": (features, len(self.reflection.parity) - even),
        }

    def draw(self, rng: np.random.Generator) -> tuple[npt.NDArray[np.int64], Single]:
        """Numbers of random snapshots, and random directions (d, p)."""
        count, parameters = self.observations.parameters.shape
        rows = rng.choice(count, min(BATCH, count), replace=False)
        return rows, rng.choice(np.array([-1.0, 1.0], np.float32), (min(DIRECTIONS, parameters), parameters))

    def gradient(self, weights: Arrays, rows: npt.NDArray[np.int64], directions: Single, out: Arrays) -> float:
        """Write the gradient of the loss of some snapshots and their derivatives in directions (d, p); return the loss.

        All that is computed is (1 + d, 2, s, ...): the value and d derivatives, of both sides, of s snapshots.
        """
        entry = _Entry.of(self.observations.parameters[rows], directions, weights["competition"], self.reflection)
        first = _Layer.of(entry.values, weights["first"], weights["first_thresholds"])
        inputs = np.concatenate([entry.values, first.values, first.values[:, ::-1]], axis=3)
        second = _Layer.of(inputs, weights["second"], weights["second_thresholds"])
        features = np.concatenate([entry.values, first.values, second.values], axis=3)
        by_features, loss = self._by_features(features, weights, rows, directions, out)
        count, neurons = weights["first"].shape
        by_inputs = second.back(by_features[..., count + neurons :], weights["second"])
        second.write(out["second"], out["second_thresholds"])
        by_first = by_features[..., count : count + neurons] + by_inputs[..., count : count + neurons]
        by_first += by_inputs[:, ::-1, :, count + neurons :]
        by_entry = by_features[..., :count] + by_inputs[..., :count] + first.back(by_first, weights["first"])
        first.write(out["first"], out["first_thresholds"])
        entry.write(by_entry, out["competition"])
        for name in ("first", "second", "even", "odd"):
            out[name] += np.float32(2.0 * DECAY) * weights[name]
            loss += DECAY * float(np.vdot(weights[name], weights[name]))
        return loss

    def _by_features(
        self, features: Single, weights: Arrays, rows: npt.NDArray[np.int64], directions: Single, out: Arrays
    ) -> tuple[Single, float]:
        """Gradient by the features, and the loss without penalties; gradients of the coefficients go to `out`."""
        derivatives = np.asarray(self.observations.derivatives)
        targets = np.empty((1 + len(directions), len(rows), derivatives.shape[2]), np.float32)
        targets[0] = self.observations.coordinates[rows]
        for place, row in enumerate(rows):
            targets[1:, place] = directions @ derivatives[row]
        shares = np.full((1 + len(directions), 1, 1), 1.0 / len(rows), np.float32)
        shares[1:] *= DERIVATIVE_WEIGHT**2 / len(directions)
        result, loss = np.zeros_like(features), 0.0
        for name, sign in (("even", 1.0), ("odd", -1.0)):
            chosen = (self.reflection.parity > 0.0) == (sign > 0.0)
            combined = features[:, 0] + np.float32(sign) * features[:, 1]
            missed = combined @ weights[name] - targets[..., chosen]
            scaled = 2.0 * shares * missed
            loss += 0.5 * float(np.vdot(scaled, missed))
            out[name][:] = _flat(combined).T @ _flat(scaled)
            by_combined = scaled @ weights[name].T
            result[:, 0] += by_combined
            result[:, 1] += np.float32(sign) * by_combined
        return result, loss


def _flat(rows: Single) -> Single:
    return rows.reshape(math.prod(rows.shape[:-1]), rows.shape[-1])


@dataclass
class _Entry:
    """The competing variables, values (1 + d, 2, s, p), and what their gradient needs."""

    values: Single
    parameters: Single
    directions: Single
    inverse: Single
    across: Single
    reflection: Reflection

    @classmethod
    def of(cls, parameters: FloatArray, directions: Single, competition: Single, reflection: Reflection) -> _Entry:
        p, along = parameters.astype(np.float32), directions[:, None]
        inverse = 1.0 / (1.0 + p @ competition)
        across = (directions @ competition)[:, None]  # derivatives of the denominators, the same for all snapshots
        values = np.empty((1 + len(directions), 2, *p.shape), np.float32)
        values[0, 0] = p * inverse
        values[1:, 0] = along * inverse - p * inverse**2 * across
        values[:, 1] = values[:, 0][..., reflection.partner] * reflection.sign.astype(np.float32)
        return cls(values, p, directions, inverse, across, reflection)

    def write(self, by_values: Single, out: Single) -> None:
        """Write the gradient by the competition (p, p), from that by the values."""
        # The mirror image of parameter i is at its partner, whose partner is i.
        turned = by_values[:, 1] * self.reflection.sign.astype(np.float32)
        ours = by_values[:, 0] + turned[..., self.reflection.partner]
        square = self.inverse**2
        slope = self.parameters * square
        by_denominators = -ours[0] * slope + 2.0 * slope * self.inverse * (ours[1:] * self.across).sum(axis=0)
        by_denominators -= square * (ours[1:] * self.directions[:, None]).sum(axis=0)
        out[:] = self.parameters.T @ by_denominators - self.directions.T @ (ours[1:] * slope).sum(axis=1)


@dataclass
class _Layer:
    """Bent combinations, values (1 + d, 2, s, h), and what their gradient needs."""

    inputs: Single
    thresholds: Single
    combined: Single
    slope: Single
    values: Single

    @classmethod
    def of(cls, inputs: Single, weights: Single, thresholds: Single) -> _Layer:
        combined = (_flat(inputs) @ weights).reshape(*inputs.shape[:-1], weights.shape[1])
        combined[0] += thresholds
        root = np.sqrt(combined[0] ** 2 + np.float32(WIDTH**2))
        slope = combined[0] / root
        values = slope * combined
        values[0] = root - np.sqrt(thresholds**2 + np.float32(WIDTH**2))
        return cls(inputs, thresholds, combined, slope, values)

    def back(self, by_values: Single, weights: Single) -> Single:
        """Gradient by the inputs, from that by the values."""
        self._by_combined = self.slope * by_values
        # phi'' = (1 - phi'^2) / root = WIDTH^2 / root^3
        bend = WIDTH**2 / (self.combined[0] ** 2 + np.float32(WIDTH**2)) ** 1.5
        self._by_combined[0] += bend * (self.combined[1:] * by_values[1:]).sum(axis=0)
        at_rest = self.thresholds / np.sqrt(self.thresholds**2 + np.float32(WIDTH**2))
        self._by_thresholds = _flat(self._by_combined[0]).sum(axis=0) - at_rest * _flat(by_values[0]).sum(axis=0)
        return (_flat(self._by_combined) @ weights.T).reshape(self.inputs.shape)

    def write(self, weights: Single, thresholds: Single) -> None:
        """Write the gradients by weights and thresholds that `back` has found."""
        weights[:] = _flat(self.inputs).T @ _flat(self._by_combined)
        thresholds[:] = self._by_thresholds
