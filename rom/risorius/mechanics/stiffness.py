"""Sparse stiffness of a body at one state."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from risorius.mechanics.body import Body
from risorius.mechanics.elements import tangent


def passive_stiffness(body: Body, nodes: int) -> sp.csr_matrix:
    """Second derivatives (3 n, 3 n) in N/m of the energy of tissue at rest, without muscles."""
    u = np.zeros((nodes, 3))
    total = sp.csr_matrix((3 * nodes, 3 * nodes))
    for table in body.passive:
        count, points, corners, _ = table.gradients.shape
        dofs = (3 * table.connectivity[:, :, None] + np.arange(3)).reshape(count, 3 * corners)
        values = np.zeros(count * (3 * corners) ** 2)
        scatter = np.arange(len(values), dtype=np.int32).reshape(count, 3 * corners, 3 * corners)
        active = np.zeros((count, points, 6))
        tables = table.connectivity, table.gradients, table.weights, table.coefficients
        tangent(u, *tables, active, True, False, scatter, values)
        rows, columns = np.repeat(dofs, 3 * corners, axis=1), np.tile(dofs, 3 * corners)
        total = total + sp.csr_matrix((values, (rows.ravel(), columns.ravel())), shape=total.shape)
    return total
