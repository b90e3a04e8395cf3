"""Fixtures shared by all tests."""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import numpy as np
import pytest

from risorius.evaluators import PolynomialMap, Superposition
from risorius.inputs import InputTable
from risorius.jaw import JawMotion
from risorius.model import Accuracy, ReducedModel


@pytest.fixture(scope="session")
def synthetic_model() -> ReducedModel:
    """A 20 x 16 grid with two muscles, a jaw and a made-up quadratic interaction: the runtime needs no more."""
    rng = np.random.default_rng(7)
    x, y = np.meshgrid(np.linspace(-0.06, 0.06, 20), np.linspace(-0.1, 0.02, 16), indexing="ij")
    rest = np.column_stack([x.ravel(), y.ravel(), 0.03 - 4.0 * x.ravel() ** 2])
    corner = np.arange(19 * 16).reshape(19, 16)[:, :15].ravel()
    triangles = np.concatenate([np.column_stack([corner, corner + 16, corner + 17]),
                                np.column_stack([corner, corner + 17, corner + 1])])  # fmt: skip
    inputs = InputTable(("zygomaticus_major_L", "zygomaticus_major_R"), has_jaw=True)
    jaw = JawMotion((0.0, -0.02, -0.06), 0.45, 0.008, 0.005, 0.008)
    modes = rng.normal(size=(6, len(rest), 3)) * 1e-3
    actions = np.zeros((5, 6))
    actions[:2, :2] = np.eye(2)
    actions[2, 2:] = 0.1
    exponents = np.array([[0, -1, -1], [1, -1, -1], [2, -1, -1], [0, 1, -1]], dtype=np.int32)
    coefficients = np.vstack([actions[:3], [0.0, 0.0, 0.0, 0.0, 0.3, 0.3]])
    accuracy = Accuracy(1e-5, 2e-5, 1e-4, 0.01, 1e-5, 1e-4, 0.95)
    return ReducedModel(
        name="synthetic",
        inputs=inputs,
        jaw=jaw,
        rest_vertices=rest.astype(np.float32),
        triangles=triangles.astype(np.int32),
        basis=np.concatenate([jaw.unit_motions(rest), modes]).astype(np.float32),
        evaluators={"superposition": Superposition(actions), "polynomial": PolynomialMap(exponents, coefficients)},
        accuracy={"superposition": accuracy, "polynomial": accuracy},
        provenance={"anatomy": "synthetic"},
    )
