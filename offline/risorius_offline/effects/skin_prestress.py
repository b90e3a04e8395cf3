"""Pre-stress of the skin: the tension it has at rest, in balance with what lies beneath."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray
from risorius_offline.effects.effect import NodeBlocks, Unobstructed

SKIN_THICKNESS = 1.5e-3  # metres; dermis and epidermis of the cheek


class SkinPrestress(Unobstructed):
    """Isotropic membrane tension sigma h (N/m) in the skin triangles (m, 3) of nodes at rest (n, 3).

    Energy sigma h/2 times the integral over the skin at rest of |grad_s u|^2: that of a tension which keeps its nominal
    value, less the dead load that balances it at rest. So the shape at rest stays in equilibrium, and the tension adds
    the stiffness of a stretched membrane (Timoshenko and Goodier 1970, membrane analogy).
    """

    def __init__(self, points: FloatArray, skin: IntArray, stress: float) -> None:
        edges = points[skin[:, [2, 0, 1]]] - points[skin[:, [1, 2, 0]]]  # edge k is opposite corner k
        double_area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
        laplacian = (
            stress * SKIN_THICKNESS * np.einsum("eai,ebi->eab", edges, edges) / (2.0 * double_area)[:, None, None]
        )
        self._skin = skin
        self._laplacian = laplacian

    def set_parameters(self, parameters: FloatArray) -> None:
        """Do nothing: the tension does not depend on the parameters."""

    def energy(self, u: FloatArray) -> float:
        """Joules, zero at rest."""
        return 0.5 * float((self._nodal(u) * u[self._skin]).sum())

    def add_forces(self, u: FloatArray, forces: FloatArray) -> float:
        """Add dE/du in newtons to `forces` (n, 3) and return the energy."""
        nodal = self._nodal(u)
        np.add.at(forces, self._skin, nodal)
        return 0.5 * float((nodal * u[self._skin]).sum())

    def second_derivatives(self, u: FloatArray, *, project: bool) -> NodeBlocks:
        """Return the constant, positive semi-definite blocks of the triangles."""
        return self._blocks

    def _nodal(self, u: FloatArray) -> FloatArray:
        return np.einsum("eab,ebi->eai", self._laplacian, u[self._skin])

    @cached_property
    def _blocks(self) -> NodeBlocks:
        matrices = np.einsum("eab,ij->eaibj", self._laplacian, np.eye(3)).reshape(len(self._skin), 9, 9)
        return NodeBlocks(self._skin, matrices)
