"""The block in felupe, after its own examples."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import felupe
import numpy as np

from peers.block import DRAG, STEPS, TOLERANCE, Block, Solution, lame

REGIONS = {"hexahedron": felupe.RegionHexahedron, "tetra10": felupe.RegionQuadraticTetra}


def prepare(block: Block, linear_solver: Any = None) -> Callable[[], Solution]:
    """Mesh, regions and boundaries; what is returned solves, by felupe's own solver unless another is given."""
    field = _field(block, block.connectivity)
    bodies = []
    for layer, young in enumerate(block.young):
        mu, lam = lame(young)
        law = felupe.NeoHookeCompressible(mu=mu, lmbda=lam)
        bodies.append(felupe.SolidBody(law, _field(block, block.connectivity[block.layer == layer])))
    bounds = felupe.BoundaryDict(
        {
            "held": felupe.Boundary(field[0], mask=block.held),
            "pulled": felupe.Boundary(field[0], mask=block.dragged, skip=(0, 1, 1)),
            "guided": felupe.Boundary(field[0], mask=block.dragged, skip=(1, 0, 0)),
        }
    )
    ramp = felupe.math.linsteps([0, 1], num=STEPS)[1:] * DRAG
    job = felupe.Job([felupe.Step(bodies, ramp={bounds["pulled"]: ramp}, boundaries=bounds)])
    options = {} if linear_solver is None else {"solver": linear_solver}

    def solve() -> Solution:
        job.evaluate(x0=field, tol=TOLERANCE, verbose=False, **options)
        iterations = sum(len(norms) for norms in job.fnorms)
        return Solution(field[0].values, iterations, iterations)

    return solve


def _field(block: Block, cells: np.ndarray) -> Any:
    mesh = felupe.Mesh(block.points, cells, block.cell_type)
    return felupe.FieldContainer([felupe.Field(REGIONS[block.cell_type](mesh), dim=3)])
