"""The sparse system of a step: element values plus node blocks, over the free components only."""

from typing import ClassVar

import numpy as np
import pytest
import scipy.sparse as sp

from risorius_offline.effects import NodeBlocks
from risorius_offline.linear_solver import ROUGH_SOLVERS, SOLVERS, SuperLU
from risorius_offline.tangent_system import TangentSystem

FREE = np.arange(3, 18)  # the first of six nodes is prescribed


def chain(count=6):
    """A dense symmetric positive definite matrix of a chain of nodes, and its upper triangle."""
    rng = np.random.default_rng(2)
    dense = np.zeros((3 * count, 3 * count))
    for first in range(count - 1):
        half = rng.normal(size=(6, 6))
        dense[3 * first : 3 * first + 6, 3 * first : 3 * first + 6] += half @ half.T + np.eye(6)
    upper = sp.csr_matrix(np.triu(dense))
    return dense, upper


def block(nodes, seed):
    half = np.random.default_rng(seed).normal(size=(1, 3 * len(nodes), 3 * len(nodes)))
    return NodeBlocks(np.array([nodes]), half @ half.transpose(0, 2, 1))


def with_blocks(dense, blocks):
    total = dense.copy()
    for item in blocks:
        dofs = (3 * item.nodes[0][:, None] + np.arange(3)).ravel()
        total[np.ix_(dofs, dofs)] += item.matrices[0]
    return total


@pytest.mark.parametrize("name", sorted(SOLVERS))
def test_blocks_add_to_the_element_values_wherever_they_couple(name):
    if name == "pardiso":
        pytest.importorskip("pypardiso")
    dense, upper = chain()
    system = TangentSystem(upper, FREE, SOLVERS[name]())
    right = np.random.default_rng(0).normal(size=(len(FREE), 2))
    far = [block([5, 1], 1), block([3], 2), block([3], 4), block([0, 4], 3)]  # 5 - 1 share no element, 0 is prescribed
    for blocks in ([], far, far[1:3], []):
        system.factorise(upper.data, blocks)
        expected = np.linalg.solve(with_blocks(dense, blocks)[np.ix_(FREE, FREE)], right)
        np.testing.assert_allclose(system.solve(right), expected, rtol=1e-9)


def test_the_pattern_is_analysed_again_only_when_a_new_pair_of_nodes_appears():
    class Counting(SuperLU):
        sizes: ClassVar[list[int]] = []

        def analyse(self, upper):
            self.sizes.append(upper.nnz)
            super().analyse(upper)

    _, upper = chain()
    system = TangentSystem(upper, FREE, Counting())
    for blocks in ([], [block([2], 1)], [block([5, 1], 1)], [block([1, 5], 2)], [block([2], 1)], [block([5, 1], 3)]):
        system.factorise(upper.data, blocks)
    assert len(Counting.sizes) == 2
    assert Counting.sizes[1] == Counting.sizes[0] + 9


def test_rough_factors_are_those_of_single_precision_and_exact_ones_come_back():
    pytest.importorskip("pypardiso")
    dense, upper = chain()
    system = TangentSystem(upper, FREE, SOLVERS["pardiso"](), ROUGH_SOLVERS["pardiso"]())
    right = np.random.default_rng(0).normal(size=len(FREE))
    expected = np.linalg.solve(dense[np.ix_(FREE, FREE)], right)

    def error(*, rough):
        system.factorise(upper.data, [], rough=rough)
        return np.linalg.norm(system.solve(right) - expected) / np.linalg.norm(expected)

    assert 1e-9 < error(rough=True) < 1e-4
    assert error(rough=False) < 1e-12
