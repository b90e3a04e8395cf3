"""The minimum of a quadratic energy over the fields that obey linear constraints."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray
from risorius_offline.linear_solver import SOLVERS, default_solver


def constrained_minimum(stiffness: sp.csr_matrix, prescribed: FloatArray, admissible: sp.csr_matrix) -> FloatArray:
    """x (n,) with the least x^T K x / 2 among `prescribed + admissible @ y`, for any y.

    stiffness: K (n, n). prescribed: (n,). admissible: (n, m), columns that span the variations left free.
    """
    if not admissible.shape[1]:
        return prescribed
    reduced = (admissible.T @ stiffness @ admissible).tocsr()
    upper = sp.triu(reduced, format="csr")
    upper.sort_indices()
    solver = SOLVERS[default_solver()]()
    solver.analyse(upper)
    solver.factorise(upper.data)
    return prescribed - admissible @ solver.solve(np.asarray(admissible.T @ (stiffness @ prescribed)))


def assembled(element_matrices: list[FloatArray], unknowns: list[IntArray], size: int) -> sp.csr_matrix:
    """Sum (size, size) of element matrices (e, k, k) over the unknowns (e, k) of each, block by block."""
    rows = [np.repeat(numbers, numbers.shape[1], axis=1).ravel() for numbers in unknowns]
    columns = [np.tile(numbers, numbers.shape[1]).ravel() for numbers in unknowns]
    values = np.concatenate([matrices.ravel() for matrices in element_matrices])
    return sp.csr_matrix((values, (np.concatenate(rows), np.concatenate(columns))), shape=(size, size))
