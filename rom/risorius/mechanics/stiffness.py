"""Sparse stiffness of a body at one state."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from risorius.jaw import FloatArray
from risorius.mechanics.body import Body
from risorius.mechanics.elements import tangent


def stiffness(body: Body, u: FloatArray, activations: FloatArray, *, project: bool = False) -> sp.csr_matrix:
    """Second derivatives (3 n, 3 n) in N/m of the energy of tissue and muscles at displacements u (n, 3).

    activations: (m,) of the muscles. project: make that of every element positive semi-definite. Walls are left out:
    they act on tissue that is about to fold.
    """
    tensors, start = (body.active @ activations).reshape(-1, 6), 0
    total = sp.csr_matrix((u.size, u.size))
    for table in body.passive:
        count, points, corners, _ = table.gradients.shape
        active = tensors[start : start + count * points]
        start += len(active)
        active = active if len(active) else np.zeros((count * points, 6))  # films come last and have no muscles
        dofs = (3 * table.connectivity[:, :, None] + np.arange(3)).reshape(count, 3 * corners)
        values = np.zeros(count * (3 * corners) ** 2)
        scatter = np.arange(len(values), dtype=np.int32).reshape(count, 3 * corners, 3 * corners)
        tables = table.connectivity, table.gradients, table.weights, table.coefficients
        tangent(u, *tables, active.reshape(count, points, 6), True, project, scatter, values)
        rows, columns = np.repeat(dofs, 3 * corners, axis=1), np.tile(dofs, 3 * corners)
        total = total + sp.csr_matrix((values, (rows.ravel(), columns.ravel())), shape=total.shape)
    return total
