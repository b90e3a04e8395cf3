"""Bases of the reduced model."""

from __future__ import annotations

import numpy as np

from risorius.jaw import FloatArray

# Snapshots are single precision: smaller singular values, relative to the largest, are rounding.
ROUNDING = 1e-6


def pod(fluctuations: FloatArray, weights: FloatArray, rank: int) -> tuple[FloatArray, FloatArray]:
    """Proper orthogonal decomposition of fluctuations (s, n, 3), orthonormal under nodal weights (n,).

    Returns modes (r, n, 3), with r = min(rank, number of snapshots), and all singular values. By the method of
    snapshots (Sirovich 1987), re-orthonormalised once, since the small eigenvalues of the correlation are inexact.
    """
    count = len(fluctuations)
    scaled = fluctuations.reshape(count, -1) * np.sqrt(np.repeat(weights, 3))
    values, vectors = np.linalg.eigh(scaled @ scaled.T)
    singular = np.sqrt(np.maximum(values[::-1], 0.0))
    kept = vectors[:, ::-1][:, : min(rank, int((singular > ROUNDING * singular[0]).sum()))]
    modes, _ = np.linalg.qr(scaled.T @ kept)
    return (modes.T / np.sqrt(np.repeat(weights, 3))).reshape(-1, *fluctuations.shape[1:]), singular
