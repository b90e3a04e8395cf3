"""Mass and damping of tissue, (7.1): M a + C v + f(u) = muscles, with Rayleigh damping C = alpha M + beta K.

Without mass, f + beta df/dt balances the muscles: where K is that at rest, tissue is at rest under loads that follow
those asked for with the time constant beta. Muscles strain the tissue, which changes K (`strain_lag`); what mass
changes is linear in vibration modes (`vibrations`).

Loads and the state without mass are taken to change linearly within a frame, and all equations are then solved exactly:
nothing grows that is not pushed, however long the frame is.
"""

from __future__ import annotations

import math
from typing import ClassVar

import h5py
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from risorius.carried_basis import CarriedBasis
from risorius.effects.effect import Surroundings
from risorius.effects.lag import OutsideLoads, lag
from risorius.effects.strain_lag import StrainedBody, StrainLag
from risorius.effects.vibrations import Vibrations, vibration_modes
from risorius.errors import InputError
from risorius.evaluators.setting import Setting
from risorius.guard import UNFOLDED
from risorius.jaw import FloatArray
from risorius.mechanics.material import MASS_DAMPING, STIFFNESS_DAMPING, TISSUE_DENSITY
from risorius.modal import visible_measure
from risorius.part import Part
from risorius.snapshot_file import Rows, SnapshotSet
from risorius.whole_steps import rounded_fields

STATES = 64  # equilibria at most, evenly chosen, that tell what tissue is pressed against


class Inertia:
    """Lag of the loads and of strained tissue, and vibration modes of its own. Not thread-safe: it owns their state.

    fields: (k, c, 3) float32, of the modes at the points that carry the skin. static: (k, r) what each mode has of the
    coordinates of the face, the first `lifts` of them of its poses. The muscles of strain_lag are the leading
    parameters, which lag; bones do not.
    """

    name: ClassVar[str] = "inertia"
    needs: ClassVar[str] = "snapshots that hold the body of their face: of muscles without the force-length relation"
    gave_way: ClassVar[float] = 0.0

    def __init__(
        self,
        fields: npt.NDArray[np.float32],
        vibrations: Vibrations,
        static: FloatArray,
        lifts: int,
        strain_lag: StrainLag,
    ) -> None:
        self.fields = rounded_fields(fields)
        self._vibrations, self._strain_lag = vibrations, strain_lag
        self._static, self._lifts = np.ascontiguousarray(static), lifts
        self._muscles = len(strain_lag.times)
        self._moving = False  # whether there was a frame before
        self._asked, self._lagged = np.zeros(self._muscles), np.zeros(self._muscles)
        self._times = np.full(self._muscles, STIFFNESS_DAMPING)
        self._outside = OutsideLoads(STIFFNESS_DAMPING)
        self._now = np.zeros(len(fields))

    @classmethod
    def train(cls, snapshots: SnapshotSet, fields: FloatArray) -> Inertia | None:
        """Return that of a face whose coordinates have the fields (r, n, 3); None where snapshots hold no body."""
        if snapshots.body is None:
            return None
        support = _support(snapshots)
        modes, squares, dampings = vibration_modes(snapshots.body, snapshots.nodal_volumes, support)
        masses = TISSUE_DENSITY * snapshots.nodal_volumes[:, None]
        static = np.tensordot(modes * masses, fields, axes=((1, 2), (1, 2)))
        carried = CarriedBasis.of_surface(snapshots.surface, modes).fields
        lifts, muscles = len(snapshots.lift_fields), len(snapshots.muscles)
        strain_lag = StrainLag.none(muscles, len(fields) - lifts)
        if snapshots.derivatives is not None:
            strain_lag = _strain_lag(
                snapshots, snapshots.derivatives, StrainedBody(snapshots.body, support), fields[lifts:]
            )
        return cls(carried, Vibrations(squares, dampings), static, lifts, strain_lag)

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
            lag(step, self._times, self._asked, asked, self._lagged)
        self._asked[:] = asked
        asked[:] = self._lagged
        return self._outside.take(surroundings, step)

    def respond(
        self, parameters: FloatArray, coordinates: FloatArray, own: FloatArray, surroundings: Surroundings
    ) -> None:
        """Add what the strain of tissue and mass change."""
        np.dot(self._static, coordinates, out=self._now)
        step = self._step(surroundings)
        self._vibrations.follow(step, self._now, own)
        self._strain_lag.add(step, self._lagged, coordinates[self._lifts :])
        self._moving = True

    @property
    def energy(self) -> float:
        """Joules in the modes: of their speed, and of their distance from rest under the present loads."""
        return self._vibrations.energy

    def finish(
        self, coordinates: FloatArray, vertices: npt.NDArray[np.float32], folds: FloatArray | None = UNFOLDED
    ) -> None:
        """Do nothing: vertices follow the coordinates."""

    def restart(self) -> None:
        """See `Effect`."""
        self._moving = False
        self._vibrations.restart()
        self._strain_lag.restart()
        self._outside.restart()

    def _step(self, surroundings: Surroundings) -> float | None:
        return surroundings.step if self._moving else None

    def at(self, setting: Setting) -> Inertia:
        """See `Effect`."""
        coordinates = np.arange(self._lifts + setting.rank)
        return self._of(self.fields, self._lifts, coordinates, np.arange(self._muscles))

    def within(self, part: Part) -> Inertia:
        """See `Effect`."""
        fields = np.ascontiguousarray(self.fields[:, part.carriers])
        muscles = part.parameters[part.parameters < self._muscles]
        return self._of(fields, len(part.lifts), part.coordinates, muscles)

    def in_axes(self, order: tuple[int, int, int]) -> Inertia:
        """See `Effect`."""
        fields = np.ascontiguousarray(self.fields[:, :, list(order)])
        return self._of(fields, self._lifts, np.arange(self._static.shape[1]), np.arange(self._muscles))

    def _of(
        self,
        fields: npt.NDArray[np.float32],
        lifts: int,
        coordinates: npt.NDArray[np.int64],
        muscles: npt.NDArray[np.int64],
    ) -> Inertia:
        """Return that of some coordinates and muscles, `lifts` of the coordinates those of poses, at rest."""
        shares = self._strain_lag.shares[np.ix_(muscles, coordinates[lifts:] - self._lifts)]
        strain_lag = StrainLag(shares, self._strain_lag.times[muscles])
        vibrations = Vibrations(self._vibrations.squares, self._vibrations.dampings)
        return Inertia(fields, vibrations, self._static[:, coordinates], lifts, strain_lag)

    def write(self, group: h5py.Group) -> None:
        """Store all fields."""
        group["fields"], group["static"] = self.fields, self._static
        group["squares"], group["dampings"] = self._vibrations.squares, self._vibrations.dampings
        group["shares"], group["times"] = self._strain_lag.shares, self._strain_lag.times
        group.attrs["lifts"], group.attrs["muscles"] = self._lifts, self._muscles

    @classmethod
    def read(cls, group: h5py.Group) -> Inertia:
        """Load what `write` stored; files from before strain lagged have neither it nor dampings of their own."""
        fields, squares, static = (group[name][()] for name in ("fields", "squares", "static"))
        lifts, muscles = int(group.attrs["lifts"]), int(group.attrs["muscles"])
        if "shares" not in group:
            vibrations = Vibrations(squares, MASS_DAMPING + STIFFNESS_DAMPING * squares)
            return cls(fields, vibrations, static, lifts, StrainLag.none(muscles, static.shape[1] - lifts))
        vibrations = Vibrations(squares, group["dampings"][()])
        return cls(fields, vibrations, static, lifts, StrainLag(group["shares"][()], group["times"][()]))


def _support(snapshots: SnapshotSet) -> sp.csr_matrix | None:
    """Mean stiffness (3 n, 3 n) in N/m of what tissue is pressed against; None where nothing is known to stop it."""
    if snapshots.springs is None:
        return None
    used = np.flatnonzero(~snapshots.held_out)
    rows = used[np.unique(np.linspace(0, len(used) - 1, min(STATES, len(used))).astype(np.int64))]
    return snapshots.springs.mean_stiffness(snapshots.displacements[row] for row in rows)


def _strain_lag(snapshots: SnapshotSet, derivatives: Rows, strained: StrainedBody, modes: FloatArray) -> StrainLag:
    """That of every muscle, from its snapshot at weight 1, in modes (r, n, 3) orthogonal under the visible measure."""
    muscles = len(snapshots.muscles)
    found = StrainLag.none(muscles, len(modes))
    weighted = modes * visible_measure(snapshots)[:, None]
    weighted /= np.einsum("rni,rni->r", weighted, modes)[:, None, None]
    for muscle, row in enumerate(snapshots.single_actions()[:muscles]):
        u, slope = (each.astype(np.float64) for each in (snapshots.displacements[row], derivatives[row][muscle]))
        missing, found.times[muscle] = strained.lag(u, snapshots.parameters[row, :muscles], slope)
        found.shares[muscle] = np.tensordot(weighted, missing, axes=2)
    return found
