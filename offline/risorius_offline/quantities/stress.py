"""Cauchy stress of the tissue, without the active stress of the muscles."""

from __future__ import annotations

import numba
import numpy as np

from risorius.jaw import FloatArray
from risorius.mechanics.point import barrier, isochoric, volumetric


@numba.njit(cache=True, error_model="numpy")
def cauchy_stress(F, dilatation, coefficients):  # type: ignore[no-untyped-def]
    """sigma = P F^T / J (k, 3, 3) in pascals of the Yeoh energy, for deformation gradients F (k, 3, 3) with J > 0.

    dilatation (k,): the J that the volumetric law sees, the element's mean or that of the point.
    coefficients (k, 3): (c10, c20, lam).
    """
    stress = np.empty_like(F)
    for k in range(len(F)):
        c10, c20, lam = coefficients[k, 0], coefficients[k, 1], coefficients[k, 2]
        left = F[k] @ F[k].T
        _, slope, _ = isochoric(c10, c20, left[0, 0] + left[1, 1] + left[2, 2])
        jacobian = np.linalg.det(F[k])
        _, wall, _ = barrier(c10, jacobian)
        _, pressure, _ = volumetric(lam, dilatation[k])
        stress[k] = 2.0 * slope / jacobian * left + (wall + pressure) * np.eye(3)
    return stress


def principal_stresses(stress: FloatArray) -> FloatArray:
    """(..., 3) principal values of stresses (..., 3, 3), the largest first."""
    return np.asarray(np.linalg.eigvalsh(stress)[..., ::-1], dtype=np.float64)


def von_mises(stress: FloatArray) -> FloatArray:
    """(...) equivalent stress sqrt(3/2 s : s) of stresses (..., 3, 3), s the deviator (von Mises 1913)."""
    deviator = stress - np.trace(stress, axis1=-2, axis2=-1)[..., None, None] / 3.0 * np.eye(3)
    return np.sqrt(1.5) * np.linalg.norm(deviator, axis=(-2, -1))
