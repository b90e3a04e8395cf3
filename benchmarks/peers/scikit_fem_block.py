"""The block in scikit-fem: idiomatic forms, full Newton, `condense` and `solve`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import skfem
from scipy.spatial import KDTree

from peers.block import CORNERS, DRAG, STEPS, TOLERANCE, Block, Solution, lame
from peers.scikit_fem_forms import Forms, Law


def prepare(block: Block, forms_of: Callable[[Law], Forms], linear_solver: Any = None) -> Callable[[], Solution]:
    """Mesh, basis and forms; what is returned solves, by scikit-fem's default solver unless another is given."""
    basis, components = _basis(block)
    fixed = np.concatenate([components[:, block.held].ravel(), components[:, block.dragged].ravel()])
    free = np.setdiff1d(np.arange(basis.N), fixed)
    mu, lam = np.array([lame(young) for young in block.young])[block.layer].T[:, :, None]
    forms = forms_of(Law(mu, lam))

    def solve() -> Solution:
        u, iterations = np.zeros(basis.N), 0
        for step in range(1, STEPS + 1):
            aim = np.zeros(basis.N)
            aim[components[0, block.dragged]] = DRAG * step / STEPS
            forces = forms.forces(basis, basis.interpolate(u))
            balanced = False
            while not balanced:
                matrix = forms.stiffness(basis, basis.interpolate(u))
                system = skfem.condense(matrix, -forces, x=aim - u, D=fixed)
                u = u + skfem.solve(*system, solver=linear_solver)
                forces = forms.forces(basis, basis.interpolate(u))
                balanced = np.linalg.norm(forces[free]) <= TOLERANCE * np.linalg.norm(forces[fixed])
                iterations += 1
        return Solution(u[components].T, iterations, iterations)

    return solve


def _basis(block: Block) -> tuple[skfem.Basis, np.ndarray]:
    """Basis, and the numbers (3, n) of every node's components: scikit-fem numbers middle nodes by itself."""
    if block.cell_type == "hexahedron":
        order = [int(np.abs(CORNERS - place).sum(axis=1).argmin()) for place in skfem.ElementHex1.doflocs]
        mesh = skfem.MeshHex(block.points.T, block.connectivity[:, order].T)
        basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementHex1()), intorder=2)
        return basis, basis.nodal_dofs
    corners, numbers = np.unique(block.connectivity[:, :4], return_inverse=True)
    mesh = skfem.MeshTet(block.points[corners].T, numbers.reshape(-1, 4).T)
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTetP2()), intorder=2)
    dofs = np.hstack([basis.nodal_dofs, basis.edge_dofs])
    return basis, dofs[:, KDTree(basis.doflocs[:, dofs[0]].T).query(block.points)[1]]
