"""Updated factors solve as the steps since the factorisation have shown, after Nocedal and Wright 2006, section 6.1."""

import numpy as np

from risorius_offline.secants import Secants

RNG = np.random.default_rng(0)
HALF = RNG.normal(size=(6, 6))
TRUE = HALF @ HALF.T + np.eye(6)
DIAGONAL = np.diag(TRUE)


def factors(right):
    return right / DIAGONAL


def visited(count):
    """Secants of a quadratic energy, and its positions."""
    secants, positions = Secants(), RNG.normal(size=(count, 6))
    for x in positions:
        secants.visit(x, TRUE @ x)
    return secants, positions


def test_the_last_change_of_gradient_is_solved_by_the_last_step():
    secants, x = visited(4)
    np.testing.assert_allclose(secants.solve(factors, TRUE @ (x[3] - x[2])), x[3] - x[2], atol=1e-12)


def test_updated_inverse_is_symmetric_and_positive_definite():
    secants, _ = visited(4)
    inverse = np.column_stack([secants.solve(factors, column) for column in np.eye(6)])
    np.testing.assert_allclose(inverse, inverse.T, atol=1e-12)
    assert np.linalg.eigvalsh(inverse).min() > 0.0


def test_new_factors_are_taken_as_they_are_until_the_next_step():
    secants, x = visited(4)
    secants.forget()
    right = RNG.normal(size=6)
    np.testing.assert_array_equal(secants.solve(factors, right), factors(right))
    secants.visit(x[0], TRUE @ x[0])
    np.testing.assert_allclose(secants.solve(factors, TRUE @ (x[0] - x[3])), x[0] - x[3], atol=1e-12)


def test_a_step_along_which_the_energy_is_not_convex_is_left_out():
    secants = Secants()
    secants.visit(np.zeros(6), np.zeros(6))
    secants.visit(np.ones(6), -np.ones(6))
    np.testing.assert_array_equal(secants.solve(factors, np.ones(6)), factors(np.ones(6)))
