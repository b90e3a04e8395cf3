"""The block in felupe, after its own examples."""

from __future__ import annotations

from typing import Any

import felupe
import numpy as np

from peers.block import DRAG, Block


def solve(block: Block, tolerance: float, linear_solver: Any = None) -> np.ndarray:
    """Displacement (n, 3); felupe's own solver unless another is given."""
    mesh = felupe.Mesh(block.points, block.hexahedra, "hexahedron")
    field = felupe.FieldContainer([felupe.Field(felupe.RegionHexahedron(mesh), dim=3)])
    mu, lam = block.lame
    solid = felupe.SolidBody(felupe.NeoHookeCompressible(mu=mu, lmbda=lam), field)
    bounds = felupe.BoundaryDict(
        {
            "held": felupe.Boundary(field[0], mask=block.held),
            "pulled": felupe.Boundary(field[0], mask=block.dragged, skip=(0, 1, 1)),
            "guided": felupe.Boundary(field[0], mask=block.dragged, skip=(1, 0, 0)),
        }
    )
    ramp = felupe.math.linsteps([0, 1], num=block.steps)[1:] * DRAG
    job = felupe.Job([felupe.Step([solid], ramp={bounds["pulled"]: ramp}, boundaries=bounds)])
    options = {} if linear_solver is None else {"solver": linear_solver}
    job.evaluate(tol=tolerance, verbose=False, **options)
    return field[0].values
