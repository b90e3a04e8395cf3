"""Squared errors of a network's values and derivatives of snapshots, and their gradient by the weights.

A batch is s snapshots and, of each, derivatives in d directions, for which the network and its derivatives are run
forward and their squared errors back (Czarnecki et al. 2017, Sobolev training). Directions are 1 or -1 in every
parameter: the mean of the squared derivatives is then the sum of those by all parameters (Hutchinson 1990).

All that is computed is (2, 1 + d, s, ...): even and odd parts of values and derivatives. Large arrays are made once: to
make them anew for each batch takes a third of the time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numba
import numpy as np
import numpy.typing as npt

from risorius.evaluators.network import COMBINED, WIDTH
from risorius.evaluators.observations import Observations, Reflection
from risorius.jaw import FloatArray
from risorius.whole_steps import Single

NEURONS_EACH, MOST_NEURONS = 10, 256  # neurons of each of the two layers, for each parameter
BATCH, DIRECTIONS = 64, 6
DERIVATIVE_WEIGHT = 0.1
DECAY = 1e-4  # penalty on the squares of all weights but thresholds and competition

PARTS = ("even", "odd")

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
            "second_even": (count + neurons, neurons),
            "second_odd": (count + neurons, neurons),
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
        for name, part in zip(PARTS, self._room.features, strict=True):
            features = _flat(roots * part).astype(np.float64)
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
        room = self._room
        count, neurons = weights["first"].shape
        middle = count + neurons
        room.features[..., :count] = entry.values
        np.matmul(_flat(room.features)[:, :count], weights["first"], out=_flat(room.first))
        _bend(room.first, weights["first_thresholds"], count, room.features)
        for name, features, combined in zip(PARTS, room.features, room.second, strict=True):
            np.matmul(_flat(features)[:, :middle], weights[f"second_{name}"], out=_flat(combined))
        _bend(room.second, weights["second_thresholds"], middle, room.features)

    def _miss(self, weights: Arrays, rows: npt.NDArray[np.int64], directions: Single, out: Arrays) -> float:
        """Write gradients by features and coefficients; return the loss without penalties."""
        room, targets, shares = self._room, self._targets(rows, directions), self._shares(rows, directions)
        loss = 0.0
        for name, features, by_features in zip(PARTS, room.features, room.by_features, strict=True):
            missed = features @ weights[name]
            missed -= targets[..., self._of(name)]
            loss += float(np.vdot(missed, shares * missed))
            missed *= 2.0 * shares
            np.matmul(_flat(features).T, _flat(missed), out=out[name])
            np.matmul(_flat(missed), weights[name].T, out=_flat(by_features))
        return loss

    def _back(self, weights: Arrays, out: Arrays) -> Single:
        """Write gradients by both layers; return that by b."""
        room = self._room
        count, neurons = weights["first"].shape
        middle = count + neurons
        _unbend(room.second, weights["second_thresholds"], middle, room.by_features, out["second_thresholds"])
        every = zip(PARTS, room.features, room.second, room.by_features, strict=True)
        for name, features, by_combined, by_features in every:
            np.matmul(_flat(features)[:, :middle].T, _flat(by_combined), out=out[f"second_{name}"])
            np.matmul(_flat(by_combined), weights[f"second_{name}"].T, out=_flat(room.by_inputs))
            by_features[..., :middle] += room.by_inputs
        _unbend(room.first, weights["first_thresholds"], count, room.by_features, out["first_thresholds"])
        np.matmul(_flat(room.features)[:, :count].T, _flat(room.first), out=out["first"])
        return room.by_features[..., :count] + room.first @ weights["first"].T


@dataclass(frozen=True)
class _Room:
    """features, by_features (2, 1 + d, s, p + 2 h): features and the gradient by them; first, second
    (2, 1 + d, s, h): combinations of a layer, then the gradient by them; by_inputs (1 + d, s, p + h): gradient by what
    the second layer combines; targets (1 + d, s, r).
    """

    features: Single
    by_features: Single
    first: Single
    second: Single
    by_inputs: Single
    targets: Single

    @classmethod
    def of(cls, fields: int, snapshots: int, shapes: dict[str, tuple[int, ...]]) -> _Room:
        count, neurons = shapes["first"]
        features, modes = shapes["even"][0], shapes["even"][1] + shapes["odd"][1]
        one = (fields, snapshots)
        sizes = [(2, *one, features)] * 2 + [(2, *one, neurons)] * 2 + [(*one, count + neurons), (*one, modes)]
        return cls(*(np.empty(size, np.float32) for size in sizes))


def _flat(rows: Single) -> Single:
    return rows.reshape(math.prod(rows.shape[:-1]), rows.shape[-1])


@dataclass
class _Entry:
    """Parts of the competing variables, values (2, 1 + d, s, p), and what their gradient needs."""

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
        ours = np.empty((1 + len(directions), *p.shape), np.float32)
        ours[0] = p * inverse
        ours[1:] = along * inverse - p * inverse**2 * across
        image = ours[..., reflection.partner] * reflection.sign.astype(np.float32)
        values = np.stack([ours + image, ours - image])
        return cls(values, p, directions, inverse, across, reflection)

    def write(self, by_values: Single, out: Single) -> None:
        """Write the gradient by the competition (p, p), from that by the values."""
        # The mirror image of parameter i is at its partner, whose partner is i.
        image = (by_values[0] - by_values[1]) * self.reflection.sign.astype(np.float32)
        ours = by_values[0] + by_values[1] + image[..., self.reflection.partner]
        square = self.inverse**2
        slope = self.parameters * square
        by_denominators = -ours[0] * slope + 2.0 * slope * self.inverse * (ours[1:] * self.across).sum(axis=0)
        by_denominators -= square * (ours[1:] * self.directions[:, None]).sum(axis=0)
        out[:] = self.parameters.T @ by_denominators - self.directions.T @ (ours[1:] * slope).sum(axis=1)


@numba.njit(cache=True, nogil=True)
def _bend(combined, thresholds, start, out):  # type: ignore[no-untyped-def]
    """Write the parts of bent combinations into features from `start` on; combinations (2, 1 + d, s, h), of which the
    parts are given, become those of the face and of its image, with thresholds.
    """
    square, half = np.float32(WIDTH * WIDTH), np.float32(0.5)
    _, fields, snapshots, neurons = combined.shape
    slopes = np.empty((2, neurons), np.float32)
    for s in range(snapshots):
        for r in range(neurons):
            even, odd = half * combined[0, 0, s, r] + thresholds[r], half * combined[1, 0, s, r]
            ours, image = even + odd, even - odd
            root, its = np.sqrt(ours * ours + square), np.sqrt(image * image + square)
            combined[0, 0, s, r], combined[1, 0, s, r] = ours, image
            slopes[0, r], slopes[1, r] = ours / root, image / its
            at_rest = np.sqrt(thresholds[r] * thresholds[r] + square)
            out[0, 0, s, start + r] = (root - at_rest) + (its - at_rest)
            out[1, 0, s, start + r] = root - its
        for k in range(1, fields):
            for r in range(neurons):
                even, odd = half * combined[0, k, s, r], half * combined[1, k, s, r]
                ours, image = even + odd, even - odd
                combined[0, k, s, r], combined[1, k, s, r] = ours, image
                ours, image = slopes[0, r] * ours, slopes[1, r] * image
                out[0, k, s, start + r] = ours + image
                out[1, k, s, start + r] = ours - image


@numba.njit(cache=True, nogil=True)
def _unbend(combined, thresholds, start, by_features, by_thresholds):  # type: ignore[no-untyped-def]
    """Put the gradient by the parts of combinations into their place, (2, 1 + d, s, h), from that by features from
    `start` on.
    """
    square, half = np.float32(WIDTH * WIDTH), np.float32(0.5)
    _, fields, snapshots, neurons = combined.shape
    slopes, curvatures, along = np.empty((3, 2, neurons), np.float32)
    by_thresholds[:] = 0.0
    for s in range(snapshots):
        for side in range(2):
            for r in range(neurons):
                z = combined[side, 0, s, r]
                root = np.sqrt(z * z + square)
                slopes[side, r], along[side, r] = z / root, 0.0
                curvatures[side, r] = square / (root * root * root)  # phi'' = (1 - phi'^2) / root
        for k in range(1, fields):
            for r in range(neurons):
                even, odd = by_features[0, k, s, start + r], by_features[1, k, s, start + r]
                ours, image = even + odd, even - odd
                along[0, r] += combined[0, k, s, r] * ours
                along[1, r] += combined[1, k, s, r] * image
                ours, image = slopes[0, r] * ours, slopes[1, r] * image
                combined[0, k, s, r], combined[1, k, s, r] = half * (ours + image), half * (ours - image)
        for r in range(neurons):
            even, odd = by_features[0, 0, s, start + r], by_features[1, 0, s, start + r]
            ours, image, threshold = even + odd, even - odd, thresholds[r]
            at_rest = threshold / np.sqrt(threshold * threshold + square)
            by_ours = slopes[0, r] * ours + curvatures[0, r] * along[0, r]
            by_image = slopes[1, r] * image + curvatures[1, r] * along[1, r]
            by_thresholds[r] += by_ours + by_image - at_rest * (ours + image)
            combined[0, 0, s, r], combined[1, 0, s, r] = (
                half * (by_ours + by_image),
                half * (by_ours - by_image),
            )
