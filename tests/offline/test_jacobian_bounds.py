"""The smallest J of a cell lies between its bounds, whatever the cell and its deformation."""

import numpy as np
import pytest

from risorius_offline.discretisation import Discretisation
from risorius_offline.elements import ELEMENTS
from risorius_offline.jacobian_bounds import jacobian_bounds
from tests.offline.meshes import box


def sampled_jacobians(discretisation, u, count=21):
    """J (cells, k) on a fine grid over every cell, its boundary with it."""
    cells = discretisation.volumes[0].cells
    grid = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, count)] * 3), axis=-1).reshape(-1, 3)
    summed = {"tetra": 3, "tetra10": 3, "wedge": 2}.get(cells.cell_type, 0)
    gradients = ELEMENTS[cells.cell_type].gradients_at(grid[grid[:, :summed].sum(axis=1) <= 1.0 + 1e-9].T)
    points = discretisation.points
    rest, deformed = (
        np.linalg.det(np.einsum("eai,qaj->eqij", x[cells.connectivity], gradients)) for x in (points, points + u)
    )
    return deformed / rest


@pytest.mark.parametrize("cell_type", sorted(ELEMENTS))
@pytest.mark.parametrize("strength", [1e-3, 2e-3, 4e-3])
def test_bounds_hold_the_smallest_jacobian_of_distorted_cells(cell_type, strength):
    rng = np.random.default_rng(0)
    points, cells = box(cell_type, (2, 2, 2), (0.02,) * 3, 0.1)
    discretisation = Discretisation(points, [cells])
    for _ in range(5):
        u = rng.normal(scale=strength, size=points.shape)
        bounds, smallest = jacobian_bounds(discretisation, u), sampled_jacobians(discretisation, u).min(axis=1)
        assert (bounds.lower <= smallest + 1e-12).all()
        assert (bounds.lower <= bounds.upper + 1e-12).all()
        # Every sign is decided, and where a grid sees J <= 0 so do the bounds.
        assert ((bounds.lower > 0.0) | (bounds.upper <= 0.0)).all()
        assert (bounds.upper[smallest <= 0.0] <= 0.0).all()
