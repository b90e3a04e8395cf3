"""What mass changes: vibration modes of tissue, driven by how the state without mass moves.

About a moving state s without mass, the distance d of a mode obeys

    d'' + c d' + w^2 d = -(s'' + alpha s')

w^2 is of tissue at rest and of what it is pressed against in the mean of its equilibria; c = alpha + beta w_t^2 with
the part w_t^2 of tissue alone, which Rayleigh damping knows of. Couplings by damping are left out.
"""

from __future__ import annotations

import math

import numba
import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from risorius.jaw import FloatArray
from risorius.mechanics.body import Body
from risorius.mechanics.material import MASS_DAMPING, STIFFNESS_DAMPING, TISSUE_DENSITY
from risorius.mechanics.stiffness import stiffness

MODES = 20


class Vibrations:
    """squares (k,): w^2 in 1/s2; dampings (k,): c in 1/s. It owns the state of its modes."""

    def __init__(self, squares: FloatArray, dampings: FloatArray) -> None:
        self.squares, self.dampings = squares, dampings
        self._before, self._place, self._speed = (np.zeros(len(squares)) for _ in range(3))

    def restart(self) -> None:
        """Be at rest."""
        for state in (self._before, self._place, self._speed):
            state[:] = 0.0

    def follow(self, step: float | None, now: FloatArray, out: FloatArray) -> None:
        """Write d (k,) a step after s was as it was told last and has moved linearly to `now`; 0 without a step."""
        if step is None:
            self._place[:] = now
            self._speed[:] = 0.0
        else:
            _vibrate(step, self.squares, self.dampings, self._before, now, self._place, self._speed)
        self._before[:] = now
        np.subtract(self._place, now, out=out)

    @property
    def energy(self) -> float:
        """Joules: of the speed of the modes, and of their distance from rest under the present loads."""
        distance = self._place - self._before
        return 0.5 * float(self._speed @ self._speed + self.squares @ (distance * distance))


def vibration_modes(
    body: Body, nodal_volumes: FloatArray, support: sp.csr_matrix | None = None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the slowest vibration modes (k, n, 3) of a body at rest, w^2 (k,) and c (k,), for lumped masses.

    nodal_volumes: (n,) cubic metres. support: (3 n, 3 n) N/m, stiffness of what the body lies on. At a unit speed a
    mode has a kinetic energy of 1/2 J.
    """
    free = np.flatnonzero(~np.repeat(body.prescribed, 3))
    scale = sp.diags_array(1.0 / np.sqrt(np.repeat(TISSUE_DENSITY * nodal_volumes, 3)[free]))
    tissue = stiffness(body, np.zeros((len(nodal_volumes), 3)), np.zeros(body.active.shape[1]))
    whole = tissue if support is None else tissue + support
    alone, supported = (sp.csc_matrix(scale @ matrix[free][:, free] @ scale) for matrix in (tissue, whole))
    count = min(MODES, len(free) - 1)
    start = np.random.default_rng(0).normal(size=len(free))  # the same modes at every training
    squares, vectors = spla.eigsh(supported, count, sigma=0.0, v0=start)
    modes = np.zeros((count, nodal_volumes.size * 3))
    modes[:, free] = vectors.T @ scale
    dampings = MASS_DAMPING + STIFFNESS_DAMPING * np.einsum("ik,ik->k", vectors, alone @ vectors)
    return modes.reshape(count, -1, 3), squares, dampings


@numba.njit(cache=True, error_model="numpy")
def _vibrate(step, squares, dampings, before, now, place, speed):  # type: ignore[no-untyped-def]
    """Take places y = s + d and speeds y' of modes on by a step in which s goes from `before` to `now`.

    y'' + c y' + w^2 y = w^2 s + (c - alpha) s'. About s - alpha s' / w^2, where a steady s' ends, it moves freely.
    """
    for k in range(len(squares)):
        square, slope = squares[k], (now[k] - before[k]) / step
        half = 0.5 * dampings[k]
        behind = MASS_DAMPING * slope / square
        z, rate = place[k] - before[k] + behind, speed[k] - slope
        cosine, sine = _free(step, square, half)
        place[k] = now[k] - behind + cosine * z + sine * (half * z + rate)
        speed[k] = slope + cosine * rate - sine * (square * z + half * rate)


@numba.njit(cache=True, error_model="numpy")
def _free(step, square, half):  # type: ignore[no-untyped-def]
    """exp(-half t) cosh(r t) and exp(-half t) sinh(r t) / r after t = step, with r^2 = half^2 - square of any sign."""
    root = math.sqrt(abs(half * half - square))
    if root * step < 1e-4:  # next to critical damping; what is left out is of the order of (root step)^4
        decay, change = math.exp(-half * step), (half * half - square) * step * step
        return decay * (1.0 + change / 2.0), decay * step * (1.0 + change / 6.0)
    if half * half < square:
        decay = math.exp(-half * step)
        return decay * math.cos(root * step), decay * math.sin(root * step) / root
    slow, fast = math.exp(-square / (half + root) * step), math.exp(-(half + root) * step)
    return 0.5 * (slow + fast), 0.5 * (slow - fast) / root
