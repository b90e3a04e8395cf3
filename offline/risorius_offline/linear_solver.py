"""Sparse direct solvers for symmetric positive definite systems, with one symbolic analysis for all factorisations."""

from __future__ import annotations

import importlib.util
import os
import weakref
from collections.abc import Callable
from typing import ClassVar, Protocol

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
import scipy.sparse.linalg as sla

from risorius.errors import SolverError
from risorius.jaw import FloatArray


class NotPositiveDefiniteError(SolverError):
    """The matrix has no Cholesky factor: the state is not a minimum along some direction."""


class LinearSolver(Protocol):
    """Solves with symmetric matrices of one pattern at a time, given by the values of the upper triangle."""

    def analyse(self, upper: sp.csr_matrix) -> None:
        """Take the pattern of a matrix, for all that follows; what was known of another is let go."""
        ...

    def factorise(self, values: FloatArray) -> None:
        """Factorise; raises NotPositiveDefiniteError."""
        ...

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Solution (n,) or (n, k) with the last factors."""
        ...


class Pardiso:
    """MKL PARDISO through pypardiso: Cholesky with its own nested dissection, in single or double precision."""

    _SYMMETRIC_POSITIVE_DEFINITE = 2
    _ANALYSE, _FACTORISE, _SOLVE = 11, 22, 33
    _ZERO_PIVOT = -4
    # MKL's parameters by number: METIS order, no refinement, no count of entries. Left to itself MKL refines
    # every solution twice, for three times the time; Newton's method mends far larger errors.
    _PARAMETERS: ClassVar = {1: 1, 2: 2, 8: 0, 18: 0}
    _IN_SINGLE_PRECISION = 28

    def __init__(self, *, single: bool = False) -> None:
        from pypardiso import PyPardisoSolver, ps

        # Importing it found MKL; a solver that is not told where searches the disk again, longer than a small solve.
        os.environ.setdefault("PYPARDISO_MKL_RT", ps.libmkl._name)
        self._solver = PyPardisoSolver(mtype=self._SYMMETRIC_POSITIVE_DEFINITE)
        for number, value in self._PARAMETERS.items():
            self._solver.set_iparm(number, value)
        self._solver.set_iparm(self._IN_SINGLE_PRECISION, int(single))
        self._dtype = np.float32 if single else np.float64
        # MKL's memory is not Python's: it has to be given back by hand.
        weakref.finalize(self, self._solver.free_memory, everything=True)

    def analyse(self, upper: sp.csr_matrix) -> None:
        """Take the pattern of a matrix, for all that follows; what was known of another is let go."""
        self._solver.free_memory(everything=True)
        ones = np.ones(len(upper.data), self._dtype)
        self._matrix = sp.csr_matrix((ones, upper.indices, upper.indptr), shape=upper.shape)
        self._unused = np.zeros((upper.shape[0], 1), self._dtype)
        self._matrix.setdiag(1.0)
        self._call(self._ANALYSE, self._unused)

    def factorise(self, values: FloatArray) -> None:
        """Factorise; raises NotPositiveDefiniteError."""
        self._matrix.data[:] = values
        self._call(self._FACTORISE, self._unused)

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Solution (n,) or (n, k) with the last factors."""
        columns: npt.NDArray[np.floating] = np.asfortranarray(
            right_hand_side.reshape(len(right_hand_side), -1), self._dtype
        )
        return np.asarray(self._call(self._SOLVE, columns), np.float64).reshape(right_hand_side.shape)

    def _call(self, phase: int, right_hand_side: npt.NDArray[np.floating]) -> npt.NDArray[np.floating]:
        from pypardiso.pardiso_wrapper import PyPardisoError

        self._solver.set_phase(phase)
        try:
            return self._solver._call_pardiso(self._matrix, right_hand_side)
        except PyPardisoError as error:
            if error.value == self._ZERO_PIVOT:
                raise NotPositiveDefiniteError("the tangent is not positive definite") from None
            raise SolverError(f"PARDISO failed with error {error.value} in phase {phase}") from error


class SuperLU:
    """SciPy's SuperLU without pivoting on a matrix in METIS order (minimum degree where METIS is absent)."""

    def analyse(self, upper: sp.csr_matrix) -> None:
        """Take the pattern of a matrix, for all that follows; what was known of another is let go."""
        numbered = sp.csr_matrix((np.arange(1.0, upper.nnz + 1), upper.indices, upper.indptr), shape=upper.shape)
        full = (numbered + sp.triu(numbered, 1).T).tocsr()
        self._order = _fill_reducing_order(full)
        permuted = full[self._order][:, self._order].tocsc()
        permuted.sort_indices()
        self._source = permuted.data.astype(np.int64) - 1
        self._pattern = permuted

    def factorise(self, values: FloatArray) -> None:
        """Factorise; raises NotPositiveDefiniteError."""
        matrix = sp.csc_matrix((values[self._source], self._pattern.indices, self._pattern.indptr), self._pattern.shape)
        options = {"SymmetricMode": True}
        try:
            self._factors = sla.splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options=options)
        except RuntimeError:
            raise NotPositiveDefiniteError("the tangent is singular") from None
        if self._factors.U.diagonal().min() <= 0.0:
            raise NotPositiveDefiniteError("the tangent is not positive definite")

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Solution (n,) or (n, k) with the last factors."""
        solution = np.empty_like(right_hand_side)
        solution[self._order] = self._factors.solve(right_hand_side[self._order])
        return solution


def _fill_reducing_order(matrix: sp.csr_matrix) -> np.ndarray:
    if importlib.util.find_spec("pymetis") is None:
        return np.asarray(sp.csgraph.reverse_cuthill_mckee(matrix, symmetric_mode=True))
    import pymetis

    graph = (matrix - sp.diags(matrix.diagonal())).tocsr()
    graph.eliminate_zeros()
    adjacency = pymetis.CSRAdjacency(graph.indptr.astype(np.int32), graph.indices.astype(np.int32))
    order, _ = pymetis.nested_dissection(adjacency)
    return np.asarray(order, dtype=np.int64)


SOLVERS: dict[str, Callable[[], LinearSolver]] = {"pardiso": Pardiso, "superlu": SuperLU}
# Of less precision for less time, where there are any: enough for a direction to descend in.
ROUGH_SOLVERS: dict[str, Callable[[], LinearSolver]] = {"pardiso": lambda: Pardiso(single=True)}


def default_solver() -> str:
    """Name of the fastest solver that is installed."""
    return "pardiso" if importlib.util.find_spec("pypardiso") else "superlu"
