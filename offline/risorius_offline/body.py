"""The body of a full model as tables, for snapshots and reduced models."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from risorius.mechanics.body import Body, PassiveElements, WallCells
from risorius_offline.full_model import FullModel
from risorius_offline.wall import Wall


def body_of(model: FullModel) -> Body:
    """Return tissue, muscles and walls of a full model whose active stress is proportional to stretch."""
    blocks = zip(model.discretisation.blocks, model.tissue.coefficients, strict=True)
    prescribed = np.zeros(len(model.discretisation.points), bool)
    prescribed[model.prescribed // 3] = True
    return Body(
        passive=tuple(
            PassiveElements(block.cells.connectivity, block.gradients, block.weights, coefficients)
            for block, coefficients in blocks
        ),
        walls=tuple(_wall_cells(wall) for wall in model.walls),
        active=sp.csr_matrix(model.tissue.active_tensors),
        dead_loads=sp.csr_matrix(model.dead_loads),
        prescribed=prescribed,
    )


def _wall_cells(wall: Wall) -> WallCells:
    connectivity = wall.connectivity[wall.cells]
    return WallCells(connectivity, wall.points[connectivity], wall.gradients, wall.form, wall.heights, wall.weights)
