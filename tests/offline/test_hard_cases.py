"""Every hard case converges to what a freshly built model confirms, or is refused with the documented error."""

import numpy as np
import pytest

from risorius_offline.equilibrium import EquilibriumSolver, NotConvergedError
from tests.offline.hard_attempts import CONVERGES, REFUSED, attempt, check, is_stable
from tests.offline.hard_cases import SMALL_CASES, face_cases
from tests.offline.hard_models import crushed_block, radius_ratios, smallest_ratio


def of(cases, expect):
    return [pytest.param(case, id=case.name) for case in cases if case.expect == expect]


def confirm(case):
    """Solve, and judge the solution by a model of its own."""
    tried = attempt(case)
    assert tried.found is not None, tried.report
    fresh = case.build()
    judged = check(case, fresh, tried.found)
    assert judged.finite
    assert judged.smallest_jacobian > 0.0
    assert judged.residual <= EquilibriumSolver.tolerance
    assert tried.report.converged
    assert tried.report.stable
    assert is_stable(fresh, tried.found.u)
    return tried.found


BACK = [case for case in SMALL_CASES if "1 to 0" in case.name]


@pytest.mark.parametrize("case", of([case for case in SMALL_CASES if case not in BACK], CONVERGES))
def test_converges_to_an_equilibrium_of_a_freshly_built_model(case):
    confirm(case)


@pytest.mark.parametrize("case", of(BACK, CONVERGES))
def test_goes_back_to_rest_from_full_activation(case):
    assert np.abs(confirm(case).u).max() < 1e-9


@pytest.mark.parametrize("case", of(SMALL_CASES, REFUSED))
def test_is_refused_with_a_report(case):
    model = case.build()
    solver, inputs = EquilibriumSolver(model, **case.settings), model.anatomy.inputs
    start = EquilibriumSolver(model).solve(case.start(inputs)) if case.start else None
    with pytest.raises(NotConvergedError, match="no equilibrium beyond") as caught:
        solver.solve(case.parameters(inputs), start)
    assert not caught.value.report.converged
    assert caught.value.report.rejected_steps > 0


def test_a_regular_tetrahedron_has_a_radius_ratio_of_one():
    regular = np.array([[[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]])
    assert abs(radius_ratios(regular)[0]) == pytest.approx(1.0)


@pytest.mark.parametrize("cell_type", ["hexahedron", "wedge", "tetra"])
def test_slivers_are_as_flat_as_they_are_said_to_be(cell_type):
    anatomy = crushed_block(cell_type)
    assert smallest_ratio(anatomy.points, anatomy.cells[0]) == pytest.approx(0.01, rel=1e-6)


@pytest.mark.slow
@pytest.mark.usefixtures("published_face")
@pytest.mark.parametrize("case", of(face_cases(), CONVERGES))
def test_published_face_converges_to_an_equilibrium_of_a_freshly_built_model(case):
    confirm(case)
