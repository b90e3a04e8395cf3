"""Mass and damping of tissue, (7.1): M a + C v + f(u) = muscles, with Rayleigh damping C = alpha M + beta K.

Without mass, f + beta df/dt balances the muscles: tissue is at rest under loads that follow those asked for with the
time constant beta. What mass changes, d, is small and linear in vibration modes of the tissue at rest with frequencies
w, where s is the state without mass:

    d'' + (alpha + beta w^2) d' + w^2 d = -(s'' + alpha s')

Loads and s are taken to change linearly within a frame, and both equations are then solved exactly: nothing grows that
is not pushed, however long the frame is.
"""

from __future__ import annotations

import math
from typing import ClassVar

import h5py
import numba
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from risorius.carried_basis import CarriedBasis
from risorius.effects.effect import Surroundings
from risorius.effects.lag import OutsideLoads, lag
from risorius.errors import InputError
from risorius.evaluators.setting import Setting
from risorius.jaw import FloatArray
from risorius.mechanics.body import Body
from risorius.mechanics.material import MASS_DAMPING, STIFFNESS_DAMPING, TISSUE_DENSITY
from risorius.mechanics.stiffness import stiffness
from risorius.part import Part
from risorius.snapshot_file import SnapshotSet

MODES = 20


class Inertia:
    """Lag of the loads, and vibration modes of its own. Not thread-safe: it owns their state.

    fields: (k, c, 3) float32, of the modes at the points that carry the skin. squares: (k,) w^2 in 1/s2. static: (k, r)
    what each mode has of the coordinates of the face, the first `lifts` of them of its poses. muscles: number of
    leading parameters that lag; bones do not.
    """

    name: ClassVar[str] = "inertia"
    needs: ClassVar[str] = "snapshots that hold the body of their face: of muscles without the force-length relation"

    def __init__(
        self, fields: npt.NDArray[np.float32], squares: FloatArray, static: FloatArray, lifts: int, muscles: int
    ) -> None:
        self.fields = fields
        self._squares, self._static, self._lifts, self._muscles = squares, np.ascontiguousarray(static), lifts, muscles
        self._moving = False  # whether there was a frame before
        self._asked, self._lagged = np.zeros(muscles), np.zeros(muscles)
        self._outside = OutsideLoads(STIFFNESS_DAMPING)
        self._now, self._before, self._place, self._speed = (np.zeros(len(squares)) for _ in range(4))

    @classmethod
    def train(cls, snapshots: SnapshotSet, fields: FloatArray) -> Inertia | None:
        """Return that of a face whose coordinates have the fields (r, n, 3); None where snapshots hold no body."""
        if snapshots.body is None:
            return None
        volumes = snapshots.nodal_volumes
        modes, squares = vibration_modes(snapshots.body, volumes)
        masses = TISSUE_DENSITY * volumes[:, None]
        static = np.tensordot(modes * masses, fields, axes=((1, 2), (1, 2)))
        carried = CarriedBasis.of_surface(snapshots.surface, modes).fields
        return cls(carried, squares, static, len(snapshots.lift_fields), len(snapshots.muscles))

    def check(self, surroundings: Surroundings) -> None:
        """Refuse a step that is not a time."""
        step = surroundings.step
        if step is not None and not 0.0 < step < math.inf:
            raise InputError(f"step {step:g} s; give the seconds since the last frame, a positive number")

    def drive(self, parameters: FloatArray, surroundings: Surroundings) -> Surroundings:
        """Let the muscles, and what acts from outside, lag behind what is asked for."""
        asked, step = parameters[: self._muscles], self._step(surroundings)
        if step is None:
            self._lagged[:] = asked
        else:
            lag(step, STIFFNESS_DAMPING, self._asked, asked, self._lagged)
        self._asked[:] = asked
        asked[:] = self._lagged
        return self._outside.take(surroundings, step)

    def respond(
        self, parameters: FloatArray, coordinates: FloatArray, own: FloatArray, surroundings: Surroundings
    ) -> None:
        """Add what mass changes."""
        np.dot(self._static, coordinates, out=self._now)
        step = self._step(surroundings)
        if step is None:
            self._place[:] = self._now
            self._speed[:] = 0.0
        else:
            _vibrate(step, self._squares, self._before, self._now, self._place, self._speed)
        self._moving = True
        self._before[:] = self._now
        np.subtract(self._place, self._now, out=own)

    @property
    def energy(self) -> float:
        """Joules in the modes: of their speed, and of their distance from rest under the present loads."""
        own = self._place - self._now
        return 0.5 * float(self._speed @ self._speed + self._squares @ (own * own))

    def finish(self, coordinates: FloatArray, vertices: npt.NDArray[np.float32]) -> None:
        """Do nothing: vertices follow the coordinates."""

    def _step(self, surroundings: Surroundings) -> float | None:
        return surroundings.step if self._moving else None

    def at(self, setting: Setting) -> Inertia:
        """See `Effect`."""
        static = self._static[:, : self._lifts + setting.rank]
        return Inertia(self.fields, self._squares, static, self._lifts, self._muscles)

    def within(self, part: Part) -> Inertia:
        """See `Effect`."""
        fields, static = np.ascontiguousarray(self.fields[:, part.carriers]), self._static[:, part.coordinates]
        muscles = int(np.searchsorted(part.parameters, self._muscles))
        return Inertia(fields, self._squares, static, len(part.lifts), muscles)

    def in_axes(self, order: tuple[int, int, int]) -> Inertia:
        """See `Effect`."""
        fields = np.ascontiguousarray(self.fields[:, :, list(order)])
        return Inertia(fields, self._squares, self._static, self._lifts, self._muscles)

    def write(self, group: h5py.Group) -> None:
        """Store all fields."""
        group["fields"], group["squares"], group["static"] = self.fields, self._squares, self._static
        group.attrs["lifts"], group.attrs["muscles"] = self._lifts, self._muscles

    @classmethod
    def read(cls, group: h5py.Group) -> Inertia:
        """Load what `write` stored."""
        fields, squares, static = (group[name][()] for name in ("fields", "squares", "static"))
        return cls(fields, squares, static, int(group.attrs["lifts"]), int(group.attrs["muscles"]))


def vibration_modes(body: Body, nodal_volumes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the slowest vibration modes (k, n, 3) of a body at rest and w^2 (k,), for lumped masses.

    nodal_volumes: (n,) cubic metres. At a unit speed a mode has a kinetic energy of 1/2 J.
    """
    free = np.flatnonzero(~np.repeat(body.prescribed, 3))
    scale = 1.0 / np.sqrt(np.repeat(TISSUE_DENSITY * nodal_volumes, 3)[free])
    at_rest = stiffness(body, np.zeros((len(nodal_volumes), 3)), np.zeros(body.active.shape[1]))[free][:, free]
    scaled = (sp.diags_array(scale) @ at_rest @ sp.diags_array(scale)).tocsc()
    count = min(MODES, len(free) - 1)
    start = np.random.default_rng(0).normal(size=len(free))  # the same modes at every training
    squares, vectors = spla.eigsh(scaled, count, sigma=0.0, v0=start)
    modes = np.zeros((count, nodal_volumes.size * 3))
    modes[:, free] = vectors.T * scale
    return modes.reshape(count, -1, 3), squares


@numba.njit(cache=True, error_model="numpy")
def _vibrate(step, squares, before, now, place, speed):  # type: ignore[no-untyped-def]
    """Take places y = s + d and speeds y' of modes on by a step in which s goes from `before` to `now`.

    y'' + c y' + w^2 y = w^2 (s + beta s') with c = alpha + beta w^2. About s - alpha s' / w^2, where a steady s' ends,
    it moves freely, and never swings: alpha beta > 1 makes c > 2 w for every w.
    """
    for k in range(len(squares)):
        square, slope = squares[k], (now[k] - before[k]) / step
        half = 0.5 * (MASS_DAMPING + STIFFNESS_DAMPING * square)
        behind = MASS_DAMPING * slope / square
        z, rate = place[k] - before[k] + behind, speed[k] - slope
        root = math.sqrt(half * half - square)
        slow, fast = math.exp(-square / (half + root) * step), math.exp(-(half + root) * step)
        cosine, sine = 0.5 * (slow + fast), 0.5 * (slow - fast) / root
        place[k] = now[k] - behind + cosine * z + sine * (half * z + rate)
        speed[k] = slope + cosine * rate - sine * (square * z + half * rate)
