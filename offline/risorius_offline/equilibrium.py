"""Static equilibria: a guarded Newton method with continuation in muscle activation and jaw pose.

Each load step minimises the energy from a predicted state. Newton directions come from a factorised tangent; when it
is not positive definite the element tangents are projected (Teran et al. 2005). A line search on the energy (Armijo)
keeps J > 0 at every point, since the energy is infinite elsewhere. Factors are kept while they contract well.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from risorius.errors import SolverError
from risorius.jaw import FloatArray
from risorius_offline.full_model import FullModel
from risorius_offline.linear_solver import NotPositiveDefiniteError

ARMIJO = 1e-4
SMALLEST_STEP_LENGTH = 1e-6
GOOD_CONTRACTION = 0.25
# Relative changes of the energy below this are rounding, and the line search cannot judge them.
ENERGY_PRECISION = 1e-13


@dataclass
class SolverReport:
    """What a solve took and reached: iteration counts, smallest J, energy (J), relative residual, load steps."""

    converged: bool = False
    iterations: int = 0
    factorisations: int = 0
    projections: int = 0
    steps: int = 0
    rejected_steps: int = 0
    smallest_jacobian: float = 1.0
    energy: float = 0.0
    residual: float = 0.0


class NotConvergedError(SolverError):
    """No equilibrium was found; `report` tells how far the solve came."""

    def __init__(self, message: str, report: SolverReport) -> None:
        super().__init__(message)
        self.report = report


@dataclass(frozen=True)
class Equilibrium:
    """A converged state: parameters (p,), displacement u (n, 3) in metres, report."""

    parameters: FloatArray
    u: FloatArray
    report: SolverReport = field(default_factory=SolverReport)


@dataclass(frozen=True)
class EquilibriumSolver:
    """Finds equilibria of a full model.

    tolerance: norm of the free forces relative to muscle and reaction forces. max_iterations: per load step.
    smallest_step: of the continuation parameter, before giving up.
    """

    model: FullModel
    tolerance: float = 1e-6
    max_iterations: int = 40
    smallest_step: float = 1.0 / 128.0

    def rest(self) -> Equilibrium:
        """The undeformed state, all parameters zero."""
        count = len(self.model.anatomy.inputs.parameters)
        return Equilibrium(np.zeros(count), np.zeros_like(self.model.anatomy.points))

    def solve(self, parameters: FloatArray, start: Equilibrium | None = None) -> Equilibrium:
        """Equilibrium at parameters (p,), reached from `start` (rest by default).

        Raises NotConvergedError, which carries the report, when continuation comes down to its smallest step.
        """
        state = start or self.rest()
        target = np.asarray(parameters, dtype=np.float64)
        report = SolverReport()
        done, step = 0.0, 1.0
        while done < 1.0:
            step = min(step, 1.0 - done)
            aim = target if step == 1.0 - done else state.parameters + step / (1.0 - done) * (target - state.parameters)
            u = self._minimise(self._predict(state, aim), aim, report)
            if u is not None:
                state = Equilibrium(aim, u)
                done += step
                step *= 2.0
                report.steps += 1
                continue
            report.rejected_steps += 1
            step *= 0.5
            if step < self.smallest_step:
                raise NotConvergedError(
                    f"no equilibrium beyond {100 * done:.1f} % of the way to {self._describe(target)}: "
                    f"residual {report.residual:.1e}, smallest J {report.smallest_jacobian:.3f} after "
                    f"{report.iterations} iterations; lower the activations or the jaw weight",
                    report,
                )
        report.converged = True
        return replace(state, report=report)

    def _predict(self, state: Equilibrium, aim: FloatArray) -> FloatArray:
        """First-order response of the tissue to the bones' increment; the bones land exactly."""
        moved = self.model.prescribed_motion(aim)
        u = state.u.copy()
        motion = self.model.anatomy.jaw_motion
        if motion is not None:
            change = motion.lift_coordinates(aim[-3:]) - motion.lift_coordinates(state.parameters[-3:])
            u += np.tensordot(change, self.model.lift_fields, axes=1)
        u.reshape(-1)[self.model.prescribed] = moved.reshape(-1)[self.model.prescribed]
        return u

    def _minimise(self, u: FloatArray, parameters: FloatArray, report: SolverReport) -> FloatArray | None:
        """Minimise the energy from u at fixed bones; None when it fails."""
        model = self.model
        model.set_parameters(parameters)
        last_residual, have_factors = np.inf, False
        for _ in range(self.max_iterations):
            energy, smallest, forces = model.forces(u)
            if not np.isfinite(energy):
                return None
            gradient = forces.reshape(-1)[model.free]
            report.residual = self._relative_residual(gradient, forces, parameters)
            report.energy, report.smallest_jacobian = energy, smallest
            if report.residual <= self.tolerance:
                return u
            contracts_well = have_factors and report.residual <= GOOD_CONTRACTION * last_residual
            following = self._step(u, gradient, energy) if contracts_well else None
            if following is None:
                if not self._factorise(u, report):
                    return None
                have_factors = True
                following = self._step(u, gradient, energy)
            if following is None:
                return None
            report.iterations += 1
            u, last_residual = following, report.residual
        return None

    def _step(self, u: FloatArray, gradient: FloatArray, energy: float) -> FloatArray | None:
        """One step with the factors at hand; None when it does not descend."""
        direction = np.zeros_like(u)
        flat = direction.reshape(-1)
        flat[self.model.free] = -self.model.solve(gradient)
        return self._line_search(u, direction, energy, float(gradient @ flat[self.model.free]))

    def _factorise(self, u: FloatArray, report: SolverReport) -> bool:
        """Factorise the tangent at u, projected where it must be; False when even that is not positive definite."""
        for project in (False, True):
            report.factorisations += 1
            report.projections += project
            try:
                self.model.factorise(u, project=project)
                return True
            except NotPositiveDefiniteError:
                continue
        return False

    def _line_search(self, u: FloatArray, direction: FloatArray, energy: float, slope: float) -> FloatArray | None:
        if slope >= 0.0:
            return None
        length = self.model.largest_step(u, direction)
        while length >= SMALLEST_STEP_LENGTH:
            trial = u + length * direction
            reached = self.model.energy(trial)
            if np.isfinite(reached) and reached <= energy + ARMIJO * length * slope + ENERGY_PRECISION * abs(energy):
                return trial
            length *= 0.5
        return None

    def _relative_residual(self, gradient: FloatArray, forces: FloatArray, parameters: FloatArray) -> float:
        scale = self.model.force_scale(forces, parameters)
        norm = float(np.linalg.norm(gradient))
        return norm / scale if scale > 0.0 else norm

    def _describe(self, parameters: FloatArray) -> str:
        names = self.model.anatomy.inputs.parameters
        return (
            ", ".join(f"{name} = {value:g}" for name, value in zip(names, parameters, strict=True) if value) or "rest"
        )
