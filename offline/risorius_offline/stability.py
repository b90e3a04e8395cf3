"""Whether an equilibrium is a minimum of the energy, and the way down from one that is not.

Newton's method keeps the symmetry of a problem, and so may end where tissue would buckle: on a saddle of the energy.
"""

from __future__ import annotations

import warnings

import numpy as np
from scipy.sparse.linalg import LinearOperator, lobpcg

from risorius.jaw import FloatArray
from risorius_offline.newton import ENERGY_PRECISION, Energy, SolverReport, factorise

# Of the central difference of forces that stands for their derivative, and of the longest way down; metres.
DIFFERENCE, LONGEST = 1e-8, 2e-3
# Only the sign of the least curvature counts, and a direction that has it.
VECTORS, ITERATIONS, PRECISION = 3, 40, 1e-3
HALVINGS = 20


def way_down(energy: Energy, u: FloatArray, report: SolverReport) -> FloatArray | None:
    """A state (n, 3) of less energy beside an equilibrium u (n, 3), None where there is none to be found.

    The report is told whether u is a minimum: whether the second derivatives there have a Cholesky factor.
    """
    level = factorise(energy, u, 0, report)
    report.stable = level == 0
    if report.stable or level is None:
        return None
    curvature, direction = _least_curvature(energy, u)
    if curvature >= 0.0:
        return None
    value, _, forces = energy.forces(u)
    # What the tolerance leaves of the forces can outweigh a small curvature, and way down there is only one.
    if np.vdot(forces, direction) > 0.0:
        direction = -direction
    lengths = LONGEST * energy.largest_step(u, LONGEST * direction) * 0.5 ** np.arange(HALVINGS)
    energies = [energy.energy(u + length * direction) for length in lengths]
    lowest = int(np.argmin(energies))
    if energies[lowest] >= value - ENERGY_PRECISION * max(abs(value), energy.energy_scale):
        return None
    lower: FloatArray = u + lengths[lowest] * direction
    return lower


def _least_curvature(energy: Energy, u: FloatArray) -> tuple[float, FloatArray]:
    """Least second derivative (N/m) along a direction (n, 3) whose largest component is 1, and the direction.

    By LOBPCG (Knyazev 2001) with the factors at hand as preconditioner.
    """

    def curved(vector: FloatArray) -> FloatArray:
        step = DIFFERENCE / max(float(np.abs(vector).max()), np.finfo(float).tiny)
        ahead, behind = (energy.forces(u + _full(energy, s * vector.ravel(), u))[2] for s in (step, -step))
        return (ahead - behind).reshape(-1)[energy.free] / (2.0 * step)

    size = (len(energy.free),) * 2
    second_derivatives = LinearOperator(size, matvec=curved, dtype=np.float64)
    preconditioner = LinearOperator(size, matvec=energy.solve, matmat=energy.solve, dtype=np.float64)
    start = np.random.default_rng(0).normal(size=(size[0], VECTORS))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # that it has not converged to its precision
        values, vectors = lobpcg(
            second_derivatives, start, M=preconditioner, largest=False, maxiter=ITERATIONS, tol=PRECISION
        )
    vector = vectors[:, int(np.argmin(values))]
    largest = float(np.abs(vector).max())
    return float(np.min(values)) / largest**2, _full(energy, vector / largest, u)


def _full(energy: Energy, free: FloatArray, u: FloatArray) -> FloatArray:
    """Displacement (n, 3) with the given free components, zero elsewhere."""
    result = np.zeros_like(u)
    result.reshape(-1)[energy.free] = free
    return result
