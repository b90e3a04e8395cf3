"""Damping of strained tissue: why a muscle's displacement does not lag as its load does.

Rayleigh damping C = beta K takes the stiffness K of tissue alone, as strained as it is, with the tangents of elements
made positive semi-definite as the full model makes them. Equilibria move with the tangent K_t of tissue and muscles.
With states s(y) at rest under loads y that lag by beta, what is missing, e, obeys to first order

    beta K e' + K_t e = beta (K_t - K) s'.

For each muscle by itself, K and K_t are taken where it is at its full: E = K^-1 (K_t - K) ds/dy there. On the way to it
E grows as the root of y, as measured on the built-in head, so that e is E times 2/3 y^(3/2) less what lags behind that
by beta (E.KE) / (E.K_t E).
"""

from __future__ import annotations

import math

import numba
import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from risorius.effects.lag import lag
from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius.mechanics.body import Body
from risorius.mechanics.material import STIFFNESS_DAMPING
from risorius.mechanics.stiffness import stiffness

CLOSE = 0.03  # relative residual of E: the rest of its theory is no closer
MOST_ITERATIONS = 1000  # it takes some ten


class StrainLag:
    """shares (m, r): E of each of m muscles in modal coordinates; times (m,): seconds that it lags. It owns a state."""

    def __init__(self, shares: FloatArray, times: FloatArray) -> None:
        self.shares, self.times = np.ascontiguousarray(shares), times
        self._now, self._before, self._lagged = (np.zeros(len(times)) for _ in range(3))

    @classmethod
    def none(cls, muscles: int, modes: int) -> StrainLag:
        """Of tissue whose damping is that at rest."""
        return cls(np.zeros((muscles, modes)), np.full(muscles, STIFFNESS_DAMPING))

    def restart(self) -> None:
        """Be at rest."""
        for state in (self._now, self._before, self._lagged):
            state[:] = 0.0

    def add(self, step: float | None, loads: FloatArray, modal: FloatArray) -> None:
        """Add e to modal coordinates (r,) at loads (m,), a step after those told last; nothing without a step."""
        elapsed = math.inf if step is None else step
        _add(elapsed, self.times, self.shares, loads, self._now, self._before, self._lagged, modal)


class StrainedBody:
    """A body whose single muscles are looked at, on what it lies on: support (3 n, 3 n) N/m, None for nothing."""

    def __init__(self, body: Body, support: sp.csr_matrix | None) -> None:
        self._body = body
        self._free = np.flatnonzero(~np.repeat(body.prescribed, 3))
        size = body.prescribed.size
        self._support = sp.csr_matrix((3 * size, 3 * size)) if support is None else support
        at_rest = stiffness(body, np.zeros((size, 3)), np.zeros(body.active.shape[1])) + self._support
        factors = spla.splu(
            sp.csc_matrix(at_rest[self._free][:, self._free]),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        self._solve = spla.LinearOperator(factors.shape, factors.solve, dtype=np.float64)

    def lag(self, u: FloatArray, activations: FloatArray, slope: FloatArray) -> tuple[FloatArray, float]:
        """E (n, 3) and its time in seconds at an equilibrium u (n, 3) that moves by slope (n, 3) per activation."""
        moving = stiffness(self._body, u, activations)
        resisting = stiffness(self._body, u, np.zeros_like(activations), project=True)
        forces = ((moving - resisting) @ slope.ravel())[self._free]
        if not forces.any():
            return np.zeros_like(u), STIFFNESS_DAMPING
        held = (resisting + self._support)[self._free][:, self._free]
        found, left = spla.cg(held, forces, rtol=CLOSE, maxiter=MOST_ITERATIONS, M=self._solve)
        if left:
            raise InputError(
                f"snapshots: damping of tissue under a single muscle was not found in {left} iterations; "
                "solve the snapshots anew"
            )
        result = np.zeros(u.size)
        result[self._free] = found
        damped, driven = found @ (held @ found), result @ ((moving + self._support) @ result)
        if driven <= 0.0:
            return np.zeros_like(u), STIFFNESS_DAMPING
        return result.reshape(u.shape), STIFFNESS_DAMPING * min(1.0, damped / driven)


@numba.njit(cache=True)
def _add(step, times, shares, loads, now, before, lagged, modal):  # type: ignore[no-untyped-def]
    """Add what is missing to modal coordinates (r,) at loads (m,); after an infinite step that is nothing."""
    for m in range(len(now)):
        load = max(loads[m], 0.0)
        now[m] = 2.0 / 3.0 * load * math.sqrt(load)
    lag(step, times, before, now, lagged)
    for m in range(len(now)):
        before[m] = now[m]
        missing = now[m] - lagged[m]
        if missing != 0.0:
            for r in range(len(modal)):
                modal[r] += missing * shares[m, r]
