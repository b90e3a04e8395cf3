"""Fixtures shared by all tests."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import numpy as np
import pytest
import scipy.sparse as sp

from risorius.accuracy import Errors
from risorius.carried_basis import CarriedBasis
from risorius.effects.gravity import Gravity
from risorius.effects.inertia import Inertia
from risorius.effects.strain_lag import StrainLag
from risorius.effects.touch import Tissue, TouchResponse
from risorius.effects.vibrations import Vibrations
from risorius.error_bound import ErrorBound
from risorius.evaluators import PolynomialMap, Setting, Superposition
from risorius.inputs import InputTable
from risorius.jaw import JawMotion
from risorius.mechanics.one_sided import OneSidedSprings
from risorius.model import ReducedModel
from risorius.operating_point import OperatingPoint, Seconds
from risorius.poses import Poses
from tests.published_face import published_face_folder
from tests.walled_model import walled


def synthetic_point(setting: Setting, error: float, seconds: float) -> OperatingPoint:
    """As if 95 % of strong frames were so far off, and ordinary ones two thirds of that."""
    ordinary = Errors(0.1 * error, 0.3 * error, error, 2.0 * error / 3.0, 0.01, 30)
    strong = Errors(0.2 * error, 0.5 * error, 2.0 * error, error, 0.02, 20)
    bound = ErrorBound(scale=1e-6, exponents=(0.1, 0.5, 0.5, 0.0))
    return OperatingPoint(
        setting, {"ordinary": ordinary, "strong": strong}, strong, Seconds(seconds, 2.0 * seconds), bound
    )


@pytest.fixture(scope="session")
def synthetic_model() -> ReducedModel:
    """A 20 x 16 grid with two muscles, a jaw and a made-up quadratic interaction: the runtime needs no more."""
    rng = np.random.default_rng(7)
    x, y = np.meshgrid(np.linspace(-0.06, 0.06, 20), np.linspace(-0.1, 0.02, 16), indexing="ij")
    rest = np.column_stack([x.ravel(), y.ravel(), 0.03 - 4.0 * x.ravel() ** 2])
    corner = np.arange(19 * 16).reshape(19, 16)[:, :15].ravel()
    triangles = np.concatenate([np.column_stack([corner, corner + 16, corner + 17]),
                                np.column_stack([corner, corner + 17, corner + 1])])  # fmt: skip
    inputs = InputTable(("zygomaticus_major_L", "zygomaticus_major_R"), JawMotion.inputs)
    jaw = JawMotion((0.0, -0.02, -0.06), 0.45, 0.008, 0.005, 0.008)
    modes = rng.normal(size=(6, len(rest), 3)) * 1e-3
    actions = np.zeros((5, 6))
    actions[:2, :2] = np.eye(2)
    actions[2, 2:] = 0.1
    exponents = np.array([[0, -1, -1], [1, -1, -1], [2, -1, -1], [0, 1, -1]], dtype=np.int32)
    coefficients = np.vstack([actions[:3], [0.0, 0.0, 0.0, 0.0, 0.3, 0.3]])
    return ReducedModel(
        name="synthetic",
        inputs=inputs,
        poses=Poses(jaw),
        rest_vertices=rest.astype(np.float32),
        triangles=triangles.astype(np.int32),
        carried_basis=CarriedBasis.of_vertices(np.concatenate([jaw.unit_motions(rest), modes]).astype(np.float32)),
        evaluators={"superposition": Superposition(actions), "polynomial": PolynomialMap(exponents, coefficients)},
        points=(
            synthetic_point(Setting("superposition", 6), error=5e-3, seconds=1e-5),
            synthetic_point(Setting("polynomial", 3), error=2e-3, seconds=2e-5),
            synthetic_point(Setting("polynomial", 6), error=1e-3, seconds=4e-5),
        ),
        provenance={"anatomy": "synthetic"},
    )


@pytest.fixture(scope="session")
def walled_model(synthetic_model: ReducedModel) -> ReducedModel:
    """The synthetic model with contact: an opened jaw takes it farther into a wall than it can be moved out of."""
    return walled(synthetic_model)


@pytest.fixture(scope="session")
def lively_model(synthetic_model: ReducedModel) -> ReducedModel:
    """The synthetic model with inertia, three vibrations that its coordinates push, gravity, and springs to touch."""
    rng = np.random.default_rng(8)
    fields = 1e-3 * rng.normal(size=(3, len(synthetic_model.rest_vertices), 3))
    static = rng.normal(size=(3, synthetic_model.rank))
    vibrations = Vibrations(np.array([1e3, 5e3, 2e4]), np.array([74.0, 150.0, 1119.0]))
    strain_lag = StrainLag(0.1 * rng.normal(size=(2, synthetic_model.rank - synthetic_model.lifts)), np.full(2, 0.03))
    inertia = Inertia(fields.astype(np.float32), vibrations, static, synthetic_model.lifts, strain_lag)
    sagging = 1e-3 * rng.normal(size=(2, len(synthetic_model.rest_vertices), 3))
    states, weights = np.eye(5)[:2], 0.02 * rng.normal(size=(2, 10))
    gravity = Gravity(sagging.astype(np.float32), 1.0, states, 0.1 * rng.normal(size=10), weights)
    vertices = len(synthetic_model.rest_vertices)
    upper = sp.diags_array(np.linspace(100.0, 300.0, 3 * vertices), format="csr")
    touch = TouchResponse(
        Tissue(upper, OneSidedSprings.none(3 * vertices)), sp.identity(3 * vertices, format="csr"), (0, 1, 2), vertices
    )
    return replace(synthetic_model, effects={"inertia": inertia, "gravity": gravity, "touch": touch})


@pytest.fixture(scope="session")
def published_face() -> Any:
    """The published face, imported once; tests of it are skipped where it is absent."""
    folder = published_face_folder()
    if not folder.is_dir():
        pytest.skip(f"the published face is not at {folder}; set RISORIUS_ANATOMY_DIR")
    from risorius_offline.anatomy import load_source

    return load_source(str(folder))


CHROMIUM = Path("/usr/bin/chromium")
FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


@pytest.fixture(scope="module")  # playwright keeps an event loop in this thread: not beyond the modules that need it
def chromium() -> Iterator[Any]:
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if not CHROMIUM.exists():
        pytest.skip(f"{CHROMIUM} is not installed")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=str(CHROMIUM), args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture(scope="session", autouse=True)
def own_ros_graph(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))  # Linux has ports for the domains 0 to 101
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        patch.setenv("ROS_LOG_DIR", str(tmp_path_factory.mktemp("ros_log")))
        yield


@pytest.fixture(scope="session")
def model_file(synthetic_model: ReducedModel, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "model.h5"
    synthetic_model.save(path)
    return path
