import numpy as np
import pytest

from risorius.mechanics.material import Yeoh
from risorius_offline.effects import DeadLoad
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel
from tests.offline.meshes import box
from tests.offline.models import block_anatomy


def test_a_bar_under_an_end_load_stretches_as_uniaxial_theory_says():
    """Neo-Hookean bar, free sides, pulled by the nominal stress P = mu (s - 1/s) + lam ln J / s."""
    material = Yeoh.neo_hookean(15e3, 0.3)
    points, cells = box("hexahedron", cells=(2, 2, 2), size=(0.02, 0.02, 0.02))
    corner, edges = points[:, 2] == 0.0, points == 0.0
    top = np.isclose(points[:, 2], 0.02)
    share = np.where(top, 1.0, 0.0)
    for axis in (0, 1):
        share *= np.where(np.isclose(points[:, axis], 0.01), 2.0, 1.0)
    stretch, mu, lam = 1.2, 2 * material.c10, material.lame
    side = lateral_stretch(stretch, mu, lam)
    nominal = mu * (stretch - 1 / stretch) + lam * np.log(stretch * side**2) / stretch
    load = np.zeros_like(points)
    load[:, 2] = nominal * 0.02**2 * share / share.sum()
    model = FullModel(
        block_anatomy(points, cells, material, fixed=np.zeros(len(points), bool)), [DeadLoad(load)], solver="superlu"
    )
    hold(model, corner, edges)
    u = EquilibriumSolver(model, tolerance=1e-11).solve(np.zeros(0)).u
    np.testing.assert_allclose(u[:, 2], (stretch - 1) * points[:, 2], atol=1e-9 * 0.02)
    np.testing.assert_allclose(u[:, 0], (side - 1) * points[:, 0], atol=1e-9 * 0.02)


def lateral_stretch(stretch, mu, lam):
    """Stretch s of the stress-free sides: mu (s^2 - 1) + lam ln(stretch s^2) = 0, by Newton's method."""
    s = 1.0
    for _ in range(50):
        s -= (mu * (s**2 - 1) + lam * np.log(stretch * s**2)) / (2 * mu * s + 2 * lam / s)
    return s


def hold(model, bottom, symmetry_planes):
    """Hold the bottom in z and the planes x = 0 and y = 0 in their normals."""
    held = symmetry_planes.copy()
    held[:, 2] = bottom
    model.free = np.flatnonzero(~held.ravel())
    model.prescribed = np.flatnonzero(held.ravel())


def test_its_energy_is_minus_its_work():
    rng = np.random.default_rng(0)
    load, u = DeadLoad(rng.normal(size=(5, 3))), rng.normal(size=(5, 3))
    forces = np.zeros((5, 3))
    assert load.add_forces(u, forces) == pytest.approx(load.energy(u))
    assert load.energy(2 * u) == pytest.approx(2 * load.energy(u))
    np.testing.assert_array_equal(forces, -load.nodal_forces)
