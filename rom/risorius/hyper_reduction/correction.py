"""Guarded Newton-CG steps: coordinates closer to equilibrium, or those that were given.

A step solves H d = -g by a few steps of preconditioned conjugate gradients without forming H, and is taken as far as
the energy falls (Armijo 1966). No step raises the energy, so that a frame is never worse than its start by the measure
that physics has.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from risorius.hyper_reduction.reduced_body import ReducedBody

Floats = npt.NDArray[np.floating]

SUFFICIENT = 1e-4  # of the decrease that the slope promises
MOST_HALVINGS = 4


class Correction:
    """Newton-CG on a reduced body; owns what it works with, so it is not thread-safe.

    preconditioner: (r, r) symmetric and positive definite, near the inverse of the stiffness.
    """

    def __init__(self, body: ReducedBody, preconditioner: Floats) -> None:
        self.body = body
        self._preconditioner = np.ascontiguousarray(preconditioner, body.q.dtype)
        self._g, self._d, self._p, self._z, self._Hp = (np.empty(body.rank, body.q.dtype) for _ in range(5))
        self._image_p, self._image_d = np.empty_like(body.u), np.empty_like(body.u)

    def run(self, q: Floats, newton_steps: int, cg_steps: int) -> float:
        """Move the body from coordinates q (r,) towards equilibrium.

        Returns the length, in the metric of the preconditioner, of the Newton step that the residual at the start asks
        for: coordinates, of which one unit is 1 mm root mean square.
        """
        body = self.body
        body.deform(q)
        energy, first = body.energy(), 0.0
        for step in range(newton_steps):
            body.gradient(self._g)
            slope, length = self._direction(cg_steps)
            first = first if step else length
            if not slope < 0.0:
                break
            energy, taken = self._search(energy, slope)
            if not taken:
                break
        return first

    def _direction(self, steps: int) -> tuple[float, float]:
        """Write direction and image; return its slope and the length of the preconditioned residual."""
        g, d, p, z = self._g, self._d, self._p, self._z
        d[:] = 0.0
        self._image_d[:] = 0.0
        np.dot(self._preconditioner, g, out=z)
        np.negative(z, out=p)
        length = float(np.linalg.norm(z))
        rz, slope = float(g @ z), 0.0
        residual = g.copy()
        for _ in range(steps):
            self.body.image(p, self._image_p)
            self.body.product(p, self._image_p, self._Hp)
            curvature = float(p @ self._Hp)
            if not curvature > 0.0:  # no minimum that way: the steepest descent so far will do
                if not d.any():
                    d[:], self._image_d[:] = p, self._image_p
                break
            alpha = rz / curvature
            d += d.dtype.type(alpha) * p
            self._image_d += d.dtype.type(alpha) * self._image_p
            residual += d.dtype.type(alpha) * self._Hp
            np.dot(self._preconditioner, residual, out=z)
            previous, rz = rz, float(residual @ z)
            p *= p.dtype.type(rz / previous)
            p -= z
        slope = float(g @ d)
        return slope, length

    def _search(self, energy: float, slope: float) -> tuple[float, bool]:
        """Move along the direction as far as the energy falls; return the energy, and whether it moved."""
        taken = 0.0
        step = 1.0
        for _ in range(MOST_HALVINGS):
            self.body.move(step - taken, self._d, self._image_d)
            taken = step
            found = self.body.energy()
            if found <= energy + SUFFICIENT * step * slope:
                return found, True
            step *= 0.5
        self.body.move(-taken, self._d, self._image_d)
        return energy, False
