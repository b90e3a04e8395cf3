"""The block in scikit-fem with idiomatic forms, after its hyperelasticity example: SciPy's SuperLU, full Newton."""

from __future__ import annotations

from typing import Any

import numpy as np
import skfem
from scipy.sparse.linalg import splu

from peers.block import DRAG, Block


def solve(block: Block, tolerance: float) -> np.ndarray:
    """Displacement (n, 3)."""
    mesh = skfem.MeshHex(block.points.T, block.hexahedra[:, _order()].T)
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementHex1()), intorder=2)
    mu, lam = block.lame
    held, dragged = basis.nodal_dofs[:, block.held].ravel(), basis.nodal_dofs[:, block.dragged]
    fixed = np.concatenate([held, dragged.ravel()])
    free = np.setdiff1d(np.arange(basis.N), fixed)
    internal, stiffness = _forms(mu, lam)
    u = np.zeros(basis.N)
    for step in range(1, block.steps + 1):
        change = np.zeros(basis.N)
        change[dragged[0]] = DRAG * step / block.steps - u[dragged[0]]
        while True:
            field = basis.interpolate(u)
            forces = internal.assemble(basis, u=field)
            reactions = np.linalg.norm(forces[fixed])
            if not change.any() and np.linalg.norm(forces[free]) <= tolerance * reactions:
                break
            matrix = stiffness.assemble(basis, u=field)
            right = -forces - matrix @ change
            change[free] = splu(matrix[free][:, free].tocsc()).solve(right[free])
            u = u + change
            change = np.zeros(basis.N)
    return u[basis.nodal_dofs].T


def _order() -> list[int]:
    """Position of scikit-fem's corners in VTK's order, from where both are."""
    vtk = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
    return [int(np.abs(vtk - place).sum(axis=1).argmin()) for place in skfem.ElementHex1.doflocs]


def _forms(mu: float, lam: float) -> tuple[skfem.LinearForm, skfem.BilinearForm]:
    def kinematics(w: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        F = w["u"].grad + np.eye(3)[:, :, None, None]
        moved = np.moveaxis(F, (0, 1), (-2, -1))
        return F, np.moveaxis(np.linalg.inv(moved), (-2, -1), (0, 1)), np.linalg.det(moved)

    @skfem.LinearForm
    def internal(v: Any, w: Any) -> np.ndarray:
        F, inverse, J = kinematics(w)
        P = mu * F + (lam * np.log(J) - mu) * np.einsum("ij...->ji...", inverse)
        return np.einsum("ij...,ij...->...", P, v.grad)

    @skfem.BilinearForm
    def stiffness(u: Any, v: Any, w: Any) -> np.ndarray:
        _, inverse, J = kinematics(w)
        along_u = np.einsum("ij...,jk...->ik...", u.grad, inverse)
        along_v = np.einsum("ij...,jk...->ik...", v.grad, inverse)
        return (
            mu * np.einsum("ij...,ij...->...", u.grad, v.grad)
            + lam * np.einsum("ii...->...", along_u) * np.einsum("ii...->...", along_v)
            + (mu - lam * np.log(J)) * np.einsum("ij...,ji...->...", along_u, along_v)
        )

    return internal, stiffness
