"""The block in our full model."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from peers.block import DRAG, POISSON, STEPS, TOLERANCE, Block, Solution
from risorius.jaw import JawMotion
from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.discretisation import CellBlock
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel


def prepare(block: Block, solver: str) -> Callable[[], Solution]:
    """Model, symbolic analysis and the predictor of load steps; what is returned solves."""
    model = _model(block, solver)
    model.lift_fields  # noqa: B018  computed on first use

    def solve() -> Solution:
        state, iterations, factorisations = None, 0, 1  # one for the predictor
        for step in range(1, STEPS + 1):
            state = EquilibriumSolver(model, TOLERANCE).solve(np.array([0.0, 0.0, step / STEPS]), state)
            if state.report.steps != 1:
                raise RuntimeError(f"load step {step} was divided: the comparison needs equal steps")
            iterations += state.report.iterations
            factorisations += state.report.factorisations
        return Solution(state.u, iterations, factorisations)

    return solve


def residual(block: Block, u: np.ndarray) -> float:
    """Norm of the free forces relative to that of the reactions at a displacement (n, 3), whichever code found it."""
    model = _model(block, "superlu")
    forces = model.forces(np.ascontiguousarray(u))[2].ravel()
    return float(np.linalg.norm(forces[model.free]) / np.linalg.norm(forces[model.prescribed]))


def _model(block: Block, solver: str) -> FullModel:
    anatomy = Anatomy(
        name="block",
        points=block.points,
        cells=(CellBlock(block.cell_type, block.connectivity, block.layer),),
        materials=tuple(Yeoh.neo_hookean(young, POISSON) for young in block.young),
        skull=block.held,
        jaw=block.dragged,
        skin=np.zeros((0, 3), dtype=np.int64),
        muscles=(),
        jaw_motion=JawMotion((0.0, 0.0, 0.0), 0.0, 0.0, 0.0, sideways_slide=DRAG),
    )
    return FullModel(anatomy, mean_dilatation=False, walled=False, solver=solver)
