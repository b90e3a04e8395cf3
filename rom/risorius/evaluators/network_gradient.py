"""Squared errors of a network's values and derivatives of snapshots, and their gradient by the weights.

A batch is s snapshots and, of each, derivatives in d directions, for which the network and its derivatives are run
forward and their squared errors back (Czarnecki et al. 2017, Sobolev training). Directions are 1 or -1 in every
parameter: the mean of the squared derivatives is then the sum of those by all parameters (Hutchinson 1990).

All that is computed is (1 + d, 2, s, ...): values and derivatives, of both sides. Large arrays are made once: to make
them anew for each batch takes a third of the time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numba
import numpy as np
import numpy.typing as npt

from risorius.evaluators.network import COMBINED, WIDTH, Single
from risorius.evaluators.observations import Observations, Reflection
from risorius.jaw import FloatArray

NEURONS_EACH, MOST_NEURONS = 10, 256  # neurons of each of the two layers, for each parameter
BATCH, DIRECTIONS = 64, 6
DERIVATIVE_WEIGHT = 0.1
DECAY = 1e-4  # penalty on the squares of all weights but thresholds and competition

SIDES = {"even": np.add, "odd": np.subtract}  # how features of both sides drive modes

Arrays = dict[str, Single]


def views(flat: Single, shapes: dict[str, tuple[int, ...]]) -> Arrays:
    """Parts of a flat array, by name, as arrays of their shapes."""
    ends = np.cumsum([math.prod(shape) for shape in shapes.values()])
    parts = np.split(flat, ends[:-1])
    return {name: part.reshape(shape) for (name, shape), part in zip(shapes.items(), parts, strict=True)}


@dataclass
class NetworkGradient:
    """Least squares of values and derivatives of snapshots by a network. Not thread-safe."""

    observations: Observations
    reflection: Reflection

    @cached_property
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

    @cached_property
    def _room(self) -> _Room:
        snapshots, parameters = self.observations.parameters.shape
        return _Room.of(1 + min(DIRECTIONS, parameters), min(BATCH, snapshots), self.shapes)

    def draw(self, rng: np.random.Generator) -> tuple[npt.NDArray[np.int64], Single]:
        """Numbers of random snapshots (s,), and random directions (d, p)."""
        count, parameters = self.observations.parameters.shape
        fields, snapshots, _ = self._room.targets.shape
        rows = rng.choice(count, (snapshots,), replace=False)
        return rows, rng.choice(np.array([-1.0, 1.0], np.float32), (fields - 1, parameters))

    def at(self, weights: Arrays, rows: npt.NDArray[np.int64], directions: Single, out: Arrays) -> float:
        """Write the gradient of the loss of a batch, of as many rows and directions as are drawn; return the loss."""
        entry = _Entry.of(self.observations.parameters[rows], directions, weights["competition"], self.reflection)
        self._forward(entry, weights)
        loss = self._miss(weights, rows, directions, out)
        entry.write(self._back(weights, out), out["competition"])
        for name in COMBINED:
            out[name] += np.float32(2.0 * DECAY) * weights[name]
            loss += DECAY * float(np.vdot(weights[name], weights[name]))
        return loss

    def normal_equations(
        self, weights: Arrays, rows: npt.NDArray[np.int64], directions: Single
    ) -> dict[str, tuple[FloatArray, FloatArray]]:
        """Matrix (f, f) and right side (f, m) of the coefficients even, odd with which a batch has least loss."""
        entry = _Entry.of(self.observations.parameters[rows], directions, weights["competition"], self.reflection)
        self._forward(entry, weights)
        targets, roots = self._targets(rows, directions), np.sqrt(self._shares(rows, directions))
        found = {}
        for name, combine in SIDES.items():
            features = _flat(roots * combine(*np.moveaxis(self._room.features, 1, 0))).astype(np.float64)
            wanted = _flat(roots * targets[..., self._of(name)])
            found[name] = features.T @ features, features.T @ wanted
        return found

    def _of(self, name: str) -> npt.NDArray[np.bool_]:
        """Modes (r,) whose coefficients are even or odd."""
        return (self.reflection.parity > 0.0) == (name == "even")

    def _targets(self, rows: npt.NDArray[np.int64], directions: Single) -> Single:
        """Values and derivatives (1 + d, s, r) of snapshots."""
        targets, derivatives = self._room.targets, np.asarray(self.observations.derivatives)
        targets[0] = self.observations.coordinates[rows]
        for place, row in enumerate(rows):
            targets[1:, place] = directions @ derivatives[row]
        return targets

    @staticmethod
    def _shares(rows: npt.NDArray[np.int64], directions: Single) -> Single:
        """Shares (1 + d, 1, 1) of their squared errors in the loss."""
        shares = np.full((1 + len(directions), 1, 1), 1.0 / len(rows), np.float32)
        shares[1:] *= DERIVATIVE_WEIGHT**2 / len(directions)
        return shares

    def _forward(self, entry: _Entry, weights: Arrays) -> None:
        """Fill in the features: b, h, k."""
        room, second = self._room, weights["second"]
        count, neurons = weights["first"].shape
        middle = count + neurons
        features = _flat(room.features)
        room.features[..., :count] = entry.values
        np.matmul(features[:, :count], weights["first"], out=_flat(room.first))
        _bend(room.first, weights["first_thresholds"], count, room.features)
        np.matmul(features[:, :middle], second[:middle], out=_flat(room.second))
        np.matmul(features[:, count:middle], second[middle:], out=_flat(room.turned))
        room.second[:] += room.turned[:, ::-1]
        _bend(room.second, weights["second_thresholds"], middle, room.features)

    def _miss(self, weights: Arrays, rows: npt.NDArray[np.int64], directions: Single, out: Arrays) -> float:
        """Write gradients by features and coefficients; return the loss without penalties."""
        room, targets, shares = self._room, self._targets(rows, directions), self._shares(rows, directions)
        loss, (ours, others) = 0.0, (room.features[:, side] for side in range(2))
        for name, combine in SIDES.items():
            combine(ours, others, out=room.combined)
            missed = room.combined @ weights[name]
            missed -= targets[..., self._of(name)]
            loss += float(np.vdot(missed, shares * missed))
            missed *= 2.0 * shares
            np.matmul(_flat(room.combined).T, _flat(missed), out=out[name])
            np.matmul(_flat(missed), weights[name].T, out=_flat(room.combined))
            if name == "even":
                room.by_features[:] = room.combined[:, None]
            else:
                room.by_features[:, 0] += room.combined
                room.by_features[:, 1] -= room.combined
        return loss

    def _back(self, weights: Arrays, out: Arrays) -> Single:
        """Write gradients by both layers; return that by b."""
        room, second = self._room, weights["second"]
        count, neurons = weights["first"].shape
        middle = count + neurons
        features = _flat(room.features)
        _unbend(room.second, weights["second_thresholds"], middle, room.by_features, out["second_thresholds"])
        room.turned[:] = room.second[:, ::-1]
        np.matmul(features[:, :middle].T, _flat(room.second), out=out["second"][:middle])
        np.matmul(features[:, count:middle].T, _flat(room.turned), out=out["second"][middle:])
        np.matmul(_flat(room.second), second[:middle].T, out=_flat(room.by_inputs))
        room.by_features[..., :middle] += room.by_inputs
        np.matmul(_flat(room.turned), second[middle:].T, out=_flat(room.second))
        room.by_features[..., count:middle] += room.second
        _unbend(room.first, weights["first_thresholds"], count, room.by_features, out["first_thresholds"])
        np.matmul(features[:, :count].T, _flat(room.first), out=out["first"])
        return room.by_features[..., :count] + room.first @ weights["first"].T


@dataclass(frozen=True)
class _Room:
    """features, by_features (1 + d, 2, s, p + 2 h): features and the gradient by them; combined: those of both sides;
    first, second, turned (1 + d, 2, s, h): combinations of a layer, then the gradient by them, and of the other side;
    by_inputs (1 + d, 2, s, p + h): gradient; targets (1 + d, s, r).
    """

    features: Single
    by_features: Single
    combined: Single
    first: Single
    second: Single
    turned: Single
    by_inputs: Single
    targets: Single

    @classmethod
    def of(cls, fields: int, snapshots: int, shapes: dict[str, tuple[int, ...]]) -> _Room:
        count, neurons = shapes["first"]
        features, modes = shapes["second"][0], shapes["even"][1] + shapes["odd"][1]
        both, one = (fields, 2, snapshots), (fields, snapshots)
        sizes = [(*both, features)] * 2 + [(*one, features)] + [(*both, neurons)] * 3
        sizes += [(*both, count + neurons), (*one, modes)]
        return cls(*(np.empty(size, np.float32) for size in sizes))


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


@numba.njit(cache=True, nogil=True)
def _bend(combined, thresholds, start, out):  # type: ignore[no-untyped-def]
    """Write bent combinations (1 + d, 2, s, h) into features from `start` on; add thresholds to the combinations."""
    square = np.float32(WIDTH * WIDTH)
    fields, sides, snapshots, neurons = combined.shape
    slope = np.empty(neurons, np.float32)
    for side in range(sides):
        for s in range(snapshots):
            for r in range(neurons):
                combined[0, side, s, r] += thresholds[r]
                z = combined[0, side, s, r]
                root = np.sqrt(z * z + square)
                slope[r] = z / root
                out[0, side, s, start + r] = root - np.sqrt(thresholds[r] * thresholds[r] + square)
            for k in range(1, fields):
                for r in range(neurons):
                    out[k, side, s, start + r] = slope[r] * combined[k, side, s, r]


@numba.njit(cache=True, nogil=True)
def _unbend(combined, thresholds, start, by_features, by_thresholds):  # type: ignore[no-untyped-def]
    """Put the gradient by combinations (1 + d, 2, s, h) into their place, from that by features from `start` on."""
    square = np.float32(WIDTH * WIDTH)
    fields, sides, snapshots, neurons = combined.shape
    slope, curvature, along = np.empty((3, neurons), np.float32)
    by_thresholds[:] = 0.0
    for side in range(sides):
        for s in range(snapshots):
            for r in range(neurons):
                z = combined[0, side, s, r]
                root = np.sqrt(z * z + square)
                slope[r], along[r] = z / root, 0.0
                curvature[r] = square / (root * root * root)  # phi'' = (1 - phi'^2) / root
            for k in range(1, fields):
                for r in range(neurons):
                    by = by_features[k, side, s, start + r]
                    along[r] += combined[k, side, s, r] * by
                    combined[k, side, s, r] = slope[r] * by
            for r in range(neurons):
                by, threshold = by_features[0, side, s, start + r], thresholds[r]
                combined[0, side, s, r] = slope[r] * by + curvature[r] * along[r]
                at_rest = threshold / np.sqrt(threshold * threshold + square)
                by_thresholds[r] += combined[0, side, s, r] - at_rest * by
