"""The law in scikit-fem: forms that derive the elasticity from the displacement, and forms that are given it.

scikit-fem calls a bilinear form for every pair of shape functions. The forms of its example 36 compute the elasticity
each time anew; who looks where the time goes computes it once for an assembly and hands it over.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import skfem
from skfem.helpers import ddot, det, grad, identity, inv, mul, trace, transpose


class Forms(Protocol):
    """Assembles nodal forces and stiffness at a displacement, given as a field."""

    def forces(self, basis: Any, u: Any) -> np.ndarray: ...

    def stiffness(self, basis: Any, u: Any) -> Any: ...


class Law:
    """mu and lam: (e, 1) by element, pascals."""

    def __init__(self, mu: np.ndarray, lam: np.ndarray) -> None:
        self.mu, self.lam = mu, lam

    def stress(self, u: Any) -> np.ndarray:
        """First Piola-Kirchhoff stress (3, 3, e, q)."""
        F = grad(u) + identity(u)
        return self.mu * F + (self.lam * np.log(det(F)) - self.mu) * transpose(inv(F))

    def elasticity(self, u: Any) -> np.ndarray:
        """Its derivative by the deformation gradient (3, 3, 3, 3, e, q)."""
        F = grad(u) + identity(u)
        G, eye = inv(F), np.eye(3)
        return (
            self.mu * np.einsum("ik,jl->ijkl", eye, eye)[..., None, None]
            + self.lam * np.einsum("ji...,lk...->ijkl...", G, G)
            + (self.mu - self.lam * np.log(det(F))) * np.einsum("jk...,li...->ijkl...", G, G)
        )


class InTheForm:
    """As in scikit-fem's example 36."""

    def __init__(self, law: Law) -> None:
        @skfem.LinearForm
        def linear(v: Any, w: Any) -> np.ndarray:
            return np.einsum("ij...,ij...", law.stress(w["displacement"]), grad(v))

        @skfem.BilinearForm
        def bilinear(u: Any, v: Any, w: Any) -> np.ndarray:
            return np.einsum("ijkl...,ij...,kl...", law.elasticity(w["displacement"]), grad(u), grad(v))

        self._linear, self._bilinear = linear, bilinear

    def forces(self, basis: Any, u: Any) -> np.ndarray:
        return self._linear.assemble(basis, displacement=u)

    def stiffness(self, basis: Any, u: Any) -> Any:
        return self._bilinear.assemble(basis, displacement=u)


class HandedOver:
    """Stress, inverse of F and what depends on J once for an assembly; the fastest forms that we found."""

    def __init__(self, law: Law) -> None:
        @skfem.LinearForm
        def linear(v: Any, w: Any) -> np.ndarray:
            return ddot(w["stress"], grad(v))

        @skfem.BilinearForm
        def bilinear(u: Any, v: Any, w: Any) -> np.ndarray:
            along_u, along_v = mul(grad(u), w["inverse"]), mul(grad(v), w["inverse"])
            return (
                law.mu * ddot(grad(u), grad(v))
                + law.lam * trace(along_u) * trace(along_v)
                + w["turning"] * ddot(along_u, transpose(along_v))
            )

        self._law, self._linear, self._bilinear = law, linear, bilinear

    def forces(self, basis: Any, u: Any) -> np.ndarray:
        return self._linear.assemble(basis, stress=self._law.stress(u))

    def stiffness(self, basis: Any, u: Any) -> Any:
        F = grad(u) + identity(u)
        turning = self._law.mu - self._law.lam * np.log(det(F))
        return self._bilinear.assemble(basis, inverse=inv(F), turning=turning)
