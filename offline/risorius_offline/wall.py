"""Keeps J > 0 everywhere in the cells."""

from __future__ import annotations

import os

import numpy as np

from risorius.jaw import FloatArray
from risorius.mechanics import wall
from risorius.mechanics.material import Yeoh
from risorius_offline.discretisation import Discretisation
from risorius_offline.jacobian_bounds import _bernstein

HEIGHT = float(os.environ.get("J0", "0.2"))
STRENGTH = float(os.environ.get("KAPPA", "1"))


class Wall:
    def __init__(self, discretisation: Discretisation, materials: tuple[Yeoh, ...]) -> None:
        c10 = np.array([material.c10 for material in materials])
        self._points = discretisation.points
        self._arrays = []
        for block, scatter in zip(discretisation.volumes, discretisation.scatter, strict=False):
            if block.cells.cell_type == "tetra" or STRENGTH == 0:
                continue
            p = _bernstein(block.cells.cell_type)
            r = p.coefficients(discretisation.points[block.cells.connectivity])
            if (r <= 0).any():
                print("NOT VALID AT REST", (r <= 0).any(axis=1).sum(), r.min())
            w = STRENGTH * c10[block.cells.layer] * block.weights.sum(axis=1) / r.shape[1]
            self._arrays.append(((block.cells.connectivity, np.ascontiguousarray(p.gradients), np.ascontiguousarray(p.from_values), HEIGHT*r, w), scatter))

    def energy(self, u: FloatArray) -> float:
        return self._integrate(u, None)

    def add_forces(self, u: FloatArray, forces: FloatArray) -> float:
        return self._integrate(u, forces)

    def _integrate(self, u, forces):
        target = np.empty((0, 3)) if forces is None else forces
        x = self._points + u
        return sum(wall.energy_and_forces(x, *arrays, forces is not None, target) for arrays, _ in self._arrays)

    def add_tangent(self, u, project, values):
        x = self._points + u
        for arrays, scatter in self._arrays:
            wall.tangent(x, *arrays, project, scatter, values)
