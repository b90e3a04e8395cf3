"""Signed height of points over the planes of triangles, and its derivatives by the place of all four.

With the edges e_1, e_2 from the first corner, their unit normal n and the tangents E^s for which E^s . e_t is 1 for
s = t and 0 otherwise, the point x at r from the first corner has the height h = n . r over its foot, whose weights are
w_s = E^s . r. Since dn = -sum_s E^s (n . de_s),

    dh  = n . y,                  y = dx - sum of w over the corners times their motion
    d2h = -sum_s ( z_s E^s . y' + E^s . y z'_s ) - h sum_st E^s . E^t z_s z'_t,     z_s = n . de_s
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from risorius.jaw import FloatArray


@dataclass(frozen=True)
class PlaneHeight:
    """Of k points: values (k,), metres; normals (k, 3); tangents (k, 2, 3), 1/m; shares (k, 4) of point and corners.

    shares are 1 for the point and minus the weight of the foot for the corners: the derivative of the height is
    shares times normal.
    """

    values: FloatArray
    normals: FloatArray
    tangents: FloatArray
    shares: FloatArray

    @classmethod
    def of(cls, places: FloatArray) -> PlaneHeight:
        """Of places (k, 4, 3): the point, and the corners of its triangle, which is not flat."""
        point, first, second, third = np.moveaxis(places, 1, 0)
        one, two, away = second - first, third - first, point - first
        normals = np.cross(one, two)
        twice = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = normals / twice
        tangents = np.stack([np.cross(two, normals), np.cross(normals, one)], axis=1) / twice[:, None]
        weights = np.einsum("ksi,ki->ks", tangents, away)
        shares = np.column_stack([np.ones(len(places)), weights.sum(axis=1) - 1.0, -weights])
        return cls(np.einsum("ki,ki->k", normals, away), normals, tangents, shares)

    def of_some(self, which: np.ndarray) -> PlaneHeight:
        """The same for some of the points."""
        return PlaneHeight(self.values[which], self.normals[which], self.tangents[which], self.shares[which])

    @property
    def gradients(self) -> FloatArray:
        """Derivatives (k, 4, 3)."""
        return self.shares[:, :, None] * self.normals[:, None, :]

    @property
    def hessians(self) -> FloatArray:
        """Second derivatives (k, 12, 12), 1/m."""
        count = len(self.values)
        along = np.einsum("ka,ksi->ksai", self.shares, self.tangents).reshape(count, 2, 12)
        turned = np.zeros((count, 2, 4, 3))
        turned[:, :, 1] = -self.normals[:, None]
        turned[:, 0, 2] = turned[:, 1, 3] = self.normals
        turning = turned.reshape(count, 2, 12)
        mixed = np.einsum("ksp,ksq->kpq", turning, along)
        metric = np.einsum("ksi,kti->kst", self.tangents, self.tangents)
        bent = np.einsum("k,kst,ksp,ktq->kpq", self.values, metric, turning, turning, optimize=True)
        result: FloatArray = -mixed - np.swapaxes(mixed, 1, 2) - bent
        return result
