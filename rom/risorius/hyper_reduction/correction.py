"""Guarded Newton-CG steps: coordinates closer to equilibrium, or those that were given.

A step solves H d = -g by a few steps of preconditioned conjugate gradients without forming H, and is taken as far as
the energy falls (Armijo 1966). No step raises the energy: by the measure that physics has, a frame is never worse than
its start.
"""

from __future__ import annotations

import numpy as np

from risorius.hyper_reduction.reduced_body import ReducedBody
from risorius.hyper_reduction.terms import Floats

CG_STEPS = 2
SUFFICIENT = 1e-4  # of the decrease that the slope promises
MOST_HALVINGS = 4


class Correction:
    """Newton-CG on a reduced body; owns what it works with, so it is not thread-safe.

    stiffness: (r, r) symmetric and positive definite, of a typical state; its inverse is the preconditioner.
    """

    def __init__(self, body: ReducedBody, stiffness: Floats) -> None:
        self.body = body
        inverse = np.linalg.inv(stiffness.astype(np.float64))
        self._preconditioner = np.ascontiguousarray(0.5 * (inverse + inverse.T), body.q.dtype)
        self._g, self._d, self._p, self._z, self._Hp = (np.empty(body.rank, body.q.dtype) for _ in range(5))
        self._residual = np.empty_like(self._g)
        self._image_p, self._image_d = np.empty_like(body.u), np.empty_like(body.u)

    def residual(self, q: Floats) -> float:
        """Take coordinates q (r,); return the length of the preconditioned residual, in units of a coordinate."""
        self.body.deform(q)
        return self._take_gradient()

    def improve(self, steps: int) -> float:
        """Take so many Newton steps from where `residual` was asked for; `body.q` is where they lead.

        Returns the length of the preconditioned residual there.
        """
        energy = self.body.energy()
        for step in range(steps):
            if step:
                self._take_gradient()
            found = self._search(energy, self._direction())
            if found is None:
                break
            energy = found
        return self._take_gradient()

    def _take_gradient(self) -> float:
        self.body.gradient(self._g)
        np.dot(self._preconditioner, self._g, out=self._z)
        return float(np.linalg.norm(self._z))

    def _direction(self) -> float:
        """Write the direction and its image by conjugate gradients; return the slope of the energy along it."""
        g, d, p, z, residual = self._g, self._d, self._p, self._z, self._residual
        number = d.dtype.type
        d[:] = 0.0
        self._image_d[:] = 0.0
        residual[:] = g
        np.negative(z, out=p)
        size = float(residual @ z)
        for _ in range(CG_STEPS):
            self.body.image(p, self._image_p)
            self.body.product(p, self._image_p, self._Hp)
            curvature = float(p @ self._Hp)
            if not curvature > 0.0:  # no minimum that way
                break
            length = number(size / curvature)
            d += length * p
            self._image_d += length * self._image_p
            residual += length * self._Hp
            np.dot(self._preconditioner, residual, out=z)
            before, size = size, float(residual @ z)
            p *= number(size / before)
            p -= z
        return float(g @ d)

    def _search(self, energy: float, slope: float) -> float | None:
        """Move as far along the direction as the energy falls and return it; None, unmoved, where it does not fall."""
        if not slope < 0.0:
            return None
        step, moved = 1.0, 0.0
        for _ in range(MOST_HALVINGS):
            self.body.move(step - moved, self._d, self._image_d)
            found = self.body.energy()
            if found <= energy + SUFFICIENT * step * slope:
                return found
            step, moved = 0.5 * step, step
        self.body.move(-moved, self._d, self._image_d)
        return None
