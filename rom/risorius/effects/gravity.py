"""Weight of the tissue when the head leaves the pose in which its shape was taken.

The displacement is linear in the change of gravity. How far tissue gives way depends on what muscles and jaw do to it:
du/dg of equilibria, from their factorised tangents, is interpolated between them by kernel ridge regression (Saunders,
Gammerman and Vovk 1998) with a Gaussian kernel. Without contact, the state at rest is one of them; with contact it is
left out: tissue then lies on bones without pressing, and its tangent knows nothing of them.
"""

from __future__ import annotations

from typing import ClassVar

import h5py
import numpy as np
import numpy.typing as npt

from risorius.effects.effect import UPRIGHT, Surroundings
from risorius.errors import InputError
from risorius.evaluators.setting import Setting
from risorius.jaw import FloatArray
from risorius.part import Part
from risorius.snapshot_file import SnapshotSet

MODES = 16
STATES = 400  # equilibria at most, evenly chosen
RIDGE, RIDGE_AT_REST = 0.3, 1e-6  # of a kernel that is 1 at its centre
LARGEST = 30.0  # m/s2: three times what weighs on Earth


class Gravity:
    """fields: (k, c, 3) float32, metres per unit of its own coordinates.

    states (t, p): parameters of equilibria; the kernel of a distance d of parameters is exp(-d^2 / (2 spread)).
    mean (3, k) and weights (t, 3 k): own coordinates per m/s2 along x, y, z are mean + kernels @ weights.
    """

    name: ClassVar[str] = "gravity"
    needs: ClassVar[str] = "snapshots of this release that hold derivatives"

    def __init__(
        self,
        fields: npt.NDArray[np.float32],
        states: FloatArray,
        spread: float,
        mean: FloatArray,
        weights: FloatArray,
    ) -> None:
        self.fields = fields
        self._states, self._spread, self._mean, self._weights = states, spread, mean, weights
        self._half_squares = 0.5 * np.square(states).sum(axis=1)

    @classmethod
    def train(cls, snapshots: SnapshotSet, fields: FloatArray) -> Gravity | None:
        """See `Effect`."""
        if snapshots.by_gravity is None or snapshots.rest_by_gravity is None:
            return None
        at_rest = int(snapshots.contact is None)
        used = np.flatnonzero(~snapshots.held_out)
        rows = used[np.unique(np.linspace(0, len(used) - 1, min(STATES, len(used))).astype(np.int64))]
        carriers = np.unique(snapshots.surface.weights.indices)
        responses = np.empty((at_rest + len(rows), 3, len(carriers), 3), np.float32)
        responses[:at_rest] = snapshots.rest_by_gravity[:, carriers]
        for out, row in zip(responses[at_rest:], rows, strict=True):
            out[:] = snapshots.by_gravity[row][:, carriers]
        states = np.vstack([np.zeros((at_rest, snapshots.parameters.shape[1])), snapshots.parameters[rows]])
        modes = _modes(responses.reshape(3 * len(states), -1))
        found = (responses.reshape(3 * len(states), -1) @ modes.T).reshape(len(states), -1).astype(np.float64)
        squares = np.square(states).sum(axis=1)
        distances = squares[:, None] + squares - 2.0 * states @ states.T
        spread = float(np.median(distances[np.triu_indices(len(states), 1)]))
        ridge = np.full(len(states), RIDGE)
        ridge[:at_rest] = RIDGE_AT_REST
        mean = found.mean(axis=0)
        weights = np.linalg.solve(np.exp(-distances / (2.0 * spread)) + np.diag(ridge), found - mean)
        return cls(modes.reshape(len(modes), -1, 3), states, spread, mean.reshape(3, -1), weights)

    def check(self, surroundings: Surroundings) -> None:
        """Refuse an acceleration that is not one of heads."""
        gravity = surroundings.gravity
        if gravity is not None and not np.linalg.norm(gravity) <= LARGEST:
            raise InputError(f"gravity {gravity} m/s2; give one of at most {LARGEST:g}, upright is (0, -9.81, 0)")

    def drive(self, parameters: FloatArray, surroundings: Surroundings) -> Surroundings:
        """Change nothing: muscles do not feel it."""
        return surroundings

    def respond(
        self, parameters: FloatArray, coordinates: FloatArray, own: FloatArray, surroundings: Surroundings
    ) -> None:
        """Let the tissue give way."""
        own[:] = 0.0
        if surroundings.gravity is None:
            return
        half_distances = self._half_squares + 0.5 * (parameters @ parameters) - self._states @ parameters
        kernels = np.exp(half_distances / -self._spread)
        np.dot(surroundings.gravity - UPRIGHT, self._mean + (kernels @ self._weights).reshape(3, -1), out=own)

    def finish(self, coordinates: FloatArray, vertices: npt.NDArray[np.float32]) -> None:
        """Do nothing: vertices follow the coordinates."""

    def at(self, setting: Setting) -> Gravity:
        """Return itself: it has no state, and does not depend on the modes of the face."""
        return self

    def within(self, part: Part) -> Gravity:
        """See `Effect`. Parameters that are left out are zero."""
        states = self._states[:, part.parameters]
        left_out = np.square(self._states).sum(axis=1) - np.square(states).sum(axis=1)
        weights = self._weights * np.exp(left_out / (-2.0 * self._spread))[:, None]
        fields = np.ascontiguousarray(self.fields[:, part.carriers])
        return Gravity(fields, np.ascontiguousarray(states), self._spread, self._mean, weights)

    def in_axes(self, order: tuple[int, int, int]) -> Gravity:
        """See `Effect`."""
        fields = np.ascontiguousarray(self.fields[:, :, list(order)])
        return Gravity(fields, self._states, self._spread, self._mean, self._weights)

    def write(self, group: h5py.Group) -> None:
        """Store all fields."""
        group["fields"], group["states"], group["mean"] = self.fields, self._states, self._mean
        group["weights"] = self._weights
        group.attrs["spread"] = self._spread

    @classmethod
    def read(cls, group: h5py.Group) -> Gravity:
        """Load what `write` stored."""
        fields, states, mean, weights = (group[name][()] for name in ("fields", "states", "mean", "weights"))
        return cls(fields, states, float(group.attrs["spread"]), mean, weights)


def _modes(responses: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Orthonormal rows (k, m) that span most of responses (s, m): method of snapshots (Sirovich 1987)."""
    gram = (responses @ responses.T).astype(np.float64)
    values, vectors = np.linalg.eigh(gram)
    kept = values[::-1][:MODES] > 1e-10 * values[-1]
    leading = vectors[:, ::-1][:, :MODES][:, kept] / np.sqrt(values[::-1][:MODES][kept])
    return np.ascontiguousarray(leading.T @ responses, np.float32)
