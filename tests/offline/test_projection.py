"""The projected density equals the one whose eigenvalues are clamped by LAPACK; see Smith, de Goes and Kim 2019."""

import numpy as np
import pytest

from risorius.mechanics import point, projection
from risorius.mechanics.material import Yeoh
from risorius_offline.full_model import FullModel
from risorius_offline.tangents import PROJECTED
from tests.offline.models import muscle_block

MATERIALS = {"neo-Hookean": (2500.0, 0.0), "Yeoh": (2500.0, 1175.0), "stiffening": (500.0, 5e4)}
STRETCHES = {"near isotropic": 1e-9, "moderate": 0.2, "high": 1.5}
FLOOR = 1e-3
NO_STRESS = np.zeros(6)


def rotation(rng):
    q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return q * np.sign(np.linalg.det(q))


def deformation(rng, spread, repeated):
    """F (9,) with J in 0.02 ... 3 and singular values that differ by exp(spread)."""
    s = np.exp(spread * rng.normal(size=3))
    if repeated:
        s[1] = s[0]
    s *= (np.exp(rng.uniform(np.log(0.02), np.log(3.0))) / s.prod()) ** (1 / 3)
    return (rotation(rng) @ np.diag(s) @ rotation(rng).T).ravel()


def density(F, material, pressure, active):
    """The arguments of `modes_below` up to the floor, and the second derivative (9, 9)."""
    c10, c20 = material
    G = np.empty(9)
    J = point.cofactor(F, G)
    _, dpsi, ddpsi = point.isochoric(c10, c20, F @ F)
    _, slope, curvature = point.barrier(c10, J)
    slope += pressure
    H = 4 * ddpsi * np.outer(F, F) + curvature * np.outer(G, G) + 2 * dpsi * np.eye(9)
    point.add_cofactor_derivative(H, F, slope)
    point.add_active_tangent(H, active)
    return (F, G, 2 * dpsi, 4 * ddpsi, slope, curvature, active), H


def projected(arguments, H, floor):
    modes, lifts = np.empty((9, 9)), np.empty(9)
    count = projection.modes_below(*arguments, floor, modes, lifts, np.empty((5, 9)))
    return H + (modes[:count].T * lifts[:count]) @ modes[:count], count


def clamped(H, floor):
    values, vectors = np.linalg.eigh(H)
    return (vectors * np.maximum(values, floor)) @ vectors.T


@pytest.mark.parametrize("repeated", [False, True])
@pytest.mark.parametrize("spread", STRETCHES.values(), ids=STRETCHES)
@pytest.mark.parametrize("material", MATERIALS.values(), ids=MATERIALS)
def test_isotropic_density_equals_the_clamped_one(material, spread, repeated):
    rng = np.random.default_rng(1)
    lifted = 0
    for pressure in np.concatenate([[0.0], *(rng.normal(size=10) * 10.0**k for k in range(2, 6))]):
        F = deformation(rng, spread, repeated)
        arguments, H = density(F, material, pressure, NO_STRESS)
        found, count = projected(arguments, H, FLOOR)
        lifted += count
        np.testing.assert_allclose(found, clamped(H, FLOOR), rtol=0, atol=1e-9 * np.abs(H).max())
    assert lifted > 0


def test_density_with_active_stress_equals_the_clamped_one():
    rng = np.random.default_rng(2)
    counts = []
    for pressure in np.concatenate([rng.normal(size=20) * 10.0**k for k in range(2, 6)]):
        x, y, z = rotation(rng)[0]
        active = 10.0 ** rng.uniform(3, 5) * np.array([x * x, y * y, z * z, x * y, y * z, z * x])
        arguments, H = density(deformation(rng, 0.2, False), MATERIALS["Yeoh"], pressure, active)
        found, count = projected(arguments, H, FLOOR)
        counts.append(count)
        np.testing.assert_allclose(found, clamped(H, FLOOR), rtol=0, atol=1e-9 * np.abs(H).max())
    assert min(counts) == 0 < max(counts)


def test_singular_values_keep_their_digits_when_they_are_small():
    exact = np.array([40.0, 1.0, 1e-6])
    rng = np.random.default_rng(3)
    F = (np.diag(exact) @ rotation(rng)).ravel()
    V = np.empty(9)
    projection.orthogonalise(F, V)
    found = np.sort(np.linalg.norm(F.reshape(3, 3), axis=0))[::-1]
    np.testing.assert_allclose(found, exact, rtol=1e-13)
    np.testing.assert_allclose(V.reshape(3, 3).T @ V.reshape(3, 3), np.eye(3), atol=1e-14)


def test_element_tangent_that_is_convex_at_every_point_is_left_alone():
    model = FullModel(muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3)), solver="superlu")
    model.set_parameters(np.array([0.7]))
    # Equal tension along all axes: the pressure makes up for the barrier, and twists and flips are far from zero.
    u = 0.01 * model.anatomy.points
    true, _ = model.tangent(u)
    assert np.array_equal(model.tangent(u, PROJECTED)[0], true)
