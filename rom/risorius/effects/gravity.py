"""Weight of the tissue when the head leaves the pose in which its shape was taken.

The displacement is linear in the change of gravity, in each of five half directions by itself: contact works one way.
How far tissue gives way depends on what muscles and jaw do to it. Where they have not moved it, it gives way as it does
at rest, where equilibria are known in which the head leans; where they have, it follows the tangent du/dg of the
equilibrium. Blended so, point by point, responses of the training snapshots are interpolated by kernel ridge regression
(Saunders, Gammerman and Vovk 1998) with a Gaussian kernel; the state at rest is one of them.
"""

from __future__ import annotations

from typing import ClassVar

import h5py
import numba
import numpy as np
import numpy.typing as npt

from risorius.effects.effect import Surroundings
from risorius.effects.leaning import HALVES, LEANING, halves, rest_responses
from risorius.errors import InputError
from risorius.evaluators.setting import Setting
from risorius.guard import UNFOLDED
from risorius.jaw import FloatArray
from risorius.part import Part
from risorius.snapshot_file import SnapshotSet
from risorius.whole_steps import rounded_fields

MODES = 16
STATES = 400  # equilibria at most, evenly chosen
UNMOVED = 0.8e-3  # metres: what has moved by less is as at rest
RIDGE, RIDGE_AT_REST = 0.1, 1e-3  # of a kernel that is 1 at its centre
LARGEST = 30.0  # m/s2: three times what weighs on Earth
TOLERANCE = 5e-6  # metres in any pose of LEANING: what the response of a part of a face may be off


class Gravity:
    """fields: (k, c, 3) float32, metres per unit of its own coordinates.

    states (t, p): parameters of equilibria, divided by the width of the kernel exp(-d^2 / 2). mean (5 k,) and weights
    (t, 5 k): own coordinates per m/s2 in the half directions are mean + kernels @ weights.
    """

    name: ClassVar[str] = "gravity"
    needs: ClassVar[str] = "snapshots of this release that hold derivatives"
    energy: ClassVar[float] = 0.0
    gave_way: ClassVar[float] = 0.0

    def __init__(
        self, fields: npt.NDArray[np.float32], width: float, states: FloatArray, mean: FloatArray, weights: FloatArray
    ) -> None:
        self.fields = rounded_fields(fields)
        self._width, self._states, self._mean, self._weights = width, states, mean, weights
        # exp(-|s - p|^2 / 2) = exp(s p) exp(-|s|^2 / 2) exp(-|p|^2 / 2), the second of which goes with the weights.
        centres = np.ascontiguousarray(states.T, np.float32)
        folded = np.exp(-0.5 * np.square(states).sum(axis=1))[:, None] * weights
        self._tables = centres, folded.astype(np.float32), mean.astype(np.float32)
        self._work = np.empty(len(states), np.float32), np.empty(len(mean), np.float32)

    @classmethod
    def train(cls, snapshots: SnapshotSet, fields: FloatArray) -> Gravity | None:
        """See `Effect`."""
        if snapshots.by_gravity is None or snapshots.leaning is None:
            return None
        used = np.flatnonzero(~snapshots.held_out)
        rows = used[np.unique(np.linspace(0, len(used) - 1, min(STATES, len(used))).astype(np.int64))]
        carriers = np.unique(snapshots.surface.weights.indices)
        responses = np.empty((1 + len(rows), len(HALVES), len(carriers), 3), np.float32)
        responses[0] = rest_responses(snapshots.leaning[:, carriers])
        for out, row in zip(responses[1:], rows, strict=True):
            moved = snapshots.displacements[row][carriers]
            as_at_rest = np.exp(-0.5 * np.square(moved / UNMOVED).sum(axis=1, keepdims=True))
            tangents = snapshots.by_gravity[row][:, carriers][HALVES]
            out[:] = tangents + as_at_rest * (responses[0] - tangents)
        states = np.vstack([np.zeros((1, snapshots.parameters.shape[1])), snapshots.parameters[rows]])
        flat = responses.reshape(len(HALVES) * len(states), -1)
        modes = _modes(flat)
        found = (flat @ modes.T).reshape(len(states), -1).astype(np.float64)
        width = float(np.sqrt(np.median(_squared_distances(states)[np.triu_indices(len(states), 1)])))
        ridge = np.full(len(states), RIDGE)
        ridge[0] = RIDGE_AT_REST
        mean = found.mean(axis=0)
        weights = np.linalg.solve(_kernel(states / width) + np.diag(ridge), found - mean)
        return cls(modes.reshape(len(modes), -1, 3), width, states / width, mean, weights)

    def check(self, surroundings: Surroundings) -> None:
        """Refuse an acceleration that is not one of heads."""
        gravity = surroundings.gravity
        if gravity is not None and not gravity @ gravity <= LARGEST**2:
            raise InputError(f"gravity {gravity} m/s2; give one of at most {LARGEST:g}, upright is (0, -9.81, 0)")

    def drive(self, parameters: FloatArray, surroundings: Surroundings) -> Surroundings:
        """Change nothing: muscles do not feel it."""
        return surroundings

    def respond(
        self, parameters: FloatArray, coordinates: FloatArray, own: FloatArray, surroundings: Surroundings
    ) -> None:
        """Let the tissue give way."""
        if surroundings.gravity is None:
            own[:] = 0.0
        else:
            _give_way(parameters, self._width, *self._tables, surroundings.gravity, *self._work, own)

    def finish(
        self, coordinates: FloatArray, vertices: npt.NDArray[np.float32], folds: FloatArray | None = UNFOLDED
    ) -> None:
        """Do nothing: vertices follow the coordinates."""

    def restart(self) -> None:
        """Do nothing: it has no state."""

    def at(self, setting: Setting) -> Gravity:
        """Return itself: it has no state, and does not depend on the modes of the face."""
        return self

    def within(self, part: Part) -> Gravity:
        """See `Effect`. Parameters that are left out are zero, and few of the states then suffice."""
        states = np.ascontiguousarray(self._states[:, part.parameters])
        left_out = np.square(self._states).sum(axis=1) - np.square(states).sum(axis=1)
        weights = np.exp(-0.5 * left_out)[:, None] * self._weights
        fields = np.ascontiguousarray(self.fields[:, part.carriers])
        return Gravity(fields, self._width, *self._fewer(states, weights, fields))

    def _fewer(
        self, states: FloatArray, weights: FloatArray, fields: npt.NDArray[np.float32]
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """States, mean and weights of an interpolant in fewer states, within TOLERANCE at all (t, p) of them."""
        kernel = _kernel(states)
        wanted, order = kernel @ weights, _pivots(kernel)
        sizes = np.linalg.norm(fields, axis=2).max(axis=1, initial=0.0)
        changes = np.abs([halves(pose) for pose in LEANING]).max(axis=0)
        metres = (changes[:, None] * sizes).ravel()
        fewest, most = 0, len(order)  # too few, enough
        while most - fewest > 1:
            count = (fewest + most) // 2
            found = _projected(kernel, order[:count], wanted)
            close = (np.abs(kernel[:, order[:count]] @ found - wanted) @ metres).max() < TOLERANCE
            fewest, most = (fewest, count) if close else (count, most)
        chosen = order[:most]
        return states[chosen], self._mean, _projected(kernel, chosen, wanted)

    def in_axes(self, order: tuple[int, int, int]) -> Gravity:
        """See `Effect`."""
        fields = np.ascontiguousarray(self.fields[:, :, list(order)])
        return Gravity(fields, self._width, self._states, self._mean, self._weights)

    def write(self, group: h5py.Group) -> None:
        """Store all fields."""
        group["fields"], group["states"], group["mean"] = self.fields, self._states, self._mean
        group["weights"] = self._weights
        group.attrs["width"] = self._width

    @classmethod
    def read(cls, group: h5py.Group) -> Gravity:
        """Load what `write` stored."""
        fields, states, mean, weights = (group[name][()] for name in ("fields", "states", "mean", "weights"))
        return cls(fields, float(group.attrs["width"]), states, mean, weights)


def _squared_distances(states: FloatArray) -> FloatArray:
    squares = np.square(states).sum(axis=1)
    return squares[:, None] + squares - 2.0 * states @ states.T


def _kernel(states: FloatArray) -> FloatArray:
    return np.asarray(np.exp(-0.5 * _squared_distances(states)))


def _pivots(kernel: FloatArray) -> npt.NDArray[np.int64]:
    """Numbers of states, each the least known from those before: pivoted Cholesky (Harbrecht et al. 2012)."""
    left, columns, order = np.diag(kernel).copy(), np.zeros((0, len(kernel))), list[int]()
    while len(order) < len(kernel) and left.max() > 1e-9:
        pivot = int(left.argmax())
        column = (kernel[pivot] - columns[:, pivot] @ columns) / np.sqrt(left[pivot])
        columns, left = np.vstack([columns, column]), left - column**2
        order.append(pivot)
    return np.array(order, np.int64)


def _projected(kernel: FloatArray, chosen: npt.NDArray[np.int64], wanted: FloatArray) -> FloatArray:
    """Weights of chosen states that come nearest to values (t, k) at all."""
    return np.asarray(np.linalg.lstsq(kernel[:, chosen], wanted, rcond=1e-10)[0])


def _modes(responses: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Orthonormal rows (k, m) that span most of responses (s, m): method of snapshots (Sirovich 1987)."""
    gram = (responses @ responses.T).astype(np.float64)
    values, vectors = np.linalg.eigh(gram)
    kept = values[::-1][:MODES] > 1e-10 * values[-1]
    leading = vectors[:, ::-1][:, :MODES][:, kept] / np.sqrt(values[::-1][:MODES][kept])
    return np.ascontiguousarray(leading.T @ responses, np.float32)


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc"})
def _give_way(parameters, width, centres, folded, base, gravity, kernels, responses, out):  # type: ignore[no-untyped-def]
    """Write own coordinates (k,) under gravity (3,); centres (p, t) across.

    Only parameters that are not 0 take time.
    """
    kernels[:] = 0.0
    square = np.float32(0.0)
    for i in range(len(parameters)):
        place = np.float32(parameters[i] / width)
        if place != 0.0:
            square += place * place
            for t in range(len(kernels)):
                kernels[t] += place * centres[i, t]
    responses[:] = 0.0
    for t in range(len(kernels)):
        kernel = np.exp(kernels[t])
        for k in range(len(responses)):
            responses[k] += kernel * folded[t, k]
    shrunk, change = np.exp(np.float32(-0.5) * square), halves(gravity)
    for k in range(len(out)):
        out[k] = 0.0
        for half in range(len(change)):
            response = half * len(out) + k
            out[k] += change[half] * (shrunk * responses[response] + base[response])
