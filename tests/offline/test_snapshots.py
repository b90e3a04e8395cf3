from dataclasses import replace

import numpy as np
import pytest

from risorius.errors import InputError, SolverError
from risorius.inputs import InputTable
from risorius.jaw import JawMotion
from risorius.mechanics.material import Yeoh
from risorius.snapshot_file import SnapshotSet
from risorius_offline.anatomy.nested_cylinders import nested_cylinders
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel
from risorius_offline.sampling import SamplingDesign, design
from risorius_offline.sensitivities import sensitivities
from risorius_offline.snapshots import solve_design
from tests.offline.hard_models import dragging, piston
from tests.offline.models import muscle_block

TABLE = InputTable(("zygomaticus_major_L", "zygomaticus_major_R", "mentalis_L", "mentalis_R"), JawMotion.inputs)


def test_design_has_every_single_action_and_is_a_prefix_of_a_longer_one():
    short, long = design(TABLE, 40, 5, seed=3), design(TABLE, 80, 5, seed=3)
    for row in np.eye(7):
        assert (short.parameters == row).all(axis=1).any()
    np.testing.assert_array_equal(short.parameters[:40], long.parameters[:40])
    np.testing.assert_array_equal(short.parameters[40:], long.parameters[80:])
    assert short.held_out.sum() == 5
    assert not (design(TABLE, 40, 5, seed=4).parameters == short.parameters).all()


def test_design_stays_in_the_admissible_range():
    parameters = design(TABLE, 300, 50, seed=0).parameters
    assert (parameters >= TABLE.parameter_lower).all()
    assert (parameters <= 1.0).all()
    assert parameters[:, -1].min() < -0.1


def levels(*values):
    return SamplingDesign(np.array(values)[:, None], np.arange(len(values)) == len(values) - 1)


@pytest.fixture
def anatomy():
    return muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3))


def test_snapshots_are_the_equilibria_and_do_not_depend_on_the_workers(anatomy, tmp_path):
    plan = levels(1.0, 0.2, 0.4, 0.6, 0.8, 0.9)
    one = solve_design(anatomy, plan, tmp_path / "one.h5", 1, lambda *_: None)
    two = solve_design(anatomy, plan, tmp_path / "two.h5", 2, lambda *_: None)
    np.testing.assert_allclose(one.displacements, two.displacements, atol=1e-9)  # a nanometre
    model = FullModel(anatomy)
    exact = EquilibriumSolver(model, tolerance=1e-11).solve(np.array([0.4]))
    np.testing.assert_allclose(one.displacements[2], exact.u, atol=1e-6 * np.abs(exact.u).max())
    slope = sensitivities(model, exact)
    np.testing.assert_allclose(one.derivatives[2], slope, atol=1e-5 * np.abs(slope).max())
    assert one.held_out.tolist() == [False] * 5 + [True]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["one.h5", "two.h5"]
    read = SnapshotSet.load(tmp_path / "one.h5")
    np.testing.assert_array_equal(read.displacements, one.displacements)
    np.testing.assert_array_equal(read.derivatives, one.derivatives)


def test_an_interrupted_run_goes_on_where_it_was(anatomy, tmp_path):
    plan = levels(*np.linspace(1.0, 0.1, 9))

    def interrupt(done, failed, total):
        if done >= 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solve_design(anatomy, plan, tmp_path / "s.h5", 1, interrupt)
    assert not (tmp_path / "s.h5").exists()
    (parts,) = tmp_path.iterdir()
    kept = {path: path.stat().st_mtime_ns for path in parts.glob("*.npz")}
    assert len(kept) >= 4
    (parts / "000001.npz").write_bytes(b"torn")  # as a kill in the middle of a write by another program would leave it
    resumed = solve_design(anatomy, plan, tmp_path / "s.h5", 2, lambda *_: None)
    fresh = solve_design(anatomy, plan, tmp_path / "fresh.h5", 2, lambda *_: None)
    np.testing.assert_allclose(resumed.displacements, fresh.displacements, atol=1e-9)  # a nanometre


def test_finished_samples_of_another_anatomy_are_never_taken(anatomy, tmp_path):
    """A fibre line that moved is another anatomy, though nodes, materials and design are the same."""
    (muscle,) = anatomy.muscles
    fibres = replace(muscle.fibres, lines=(muscle.fibres.lines[0] + [0.0, 0.004, 0.0],))
    moved = replace(anatomy, muscles=(replace(muscle, fibres=fibres),))

    def interrupt(done, failed, total):
        if done >= 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solve_design(anatomy, levels(1.0, 0.5), tmp_path / "s.h5", 1, interrupt)
    ours = solve_design(moved, levels(1.0, 0.5), tmp_path / "s.h5", 1, lambda *_: None)
    exact = EquilibriumSolver(FullModel(moved), tolerance=1e-11).solve(np.array([1.0])).u
    np.testing.assert_allclose(ours.displacements[0], exact, atol=1e-6 * np.abs(exact).max())


def test_every_point_of_every_snapshot_keeps_its_orientation(tmp_path):
    plan = levels(1.0, 0.5, 0.75)
    snapshots = solve_design(nested_cylinders(), plan, tmp_path / "s.h5", 2, lambda *_: None)
    model = FullModel(nested_cylinders())
    for u, smallest in zip(snapshots.displacements, snapshots.smallest_jacobians, strict=True):
        assert model.point_jacobians(u.astype(np.float64)).min() == pytest.approx(smallest, rel=1e-5)
        assert smallest > 0


def test_a_run_in_which_nothing_can_be_solved_says_so(tmp_path):
    """The top of a confined column of 30 mm is pushed down by 40: no state has J > 0."""
    impossible = SamplingDesign(np.array([[0.0, 10.0, 0.0]]), np.array([False]))
    with pytest.raises(SolverError, match=r"none of the 1 snapshots could be solved; the first: no equilibrium"):
        solve_design(piston("hexahedron", dragging(along=-0.004)), impossible, tmp_path / "s.h5", 1, lambda *_: None)


def test_a_missing_output_folder_is_named_before_anything_is_solved(anatomy, tmp_path):
    with pytest.raises(InputError, match=r"the folder .*nowhere does not exist; create it"):
        solve_design(anatomy, levels(1.0), tmp_path / "nowhere" / "s.h5", 1, lambda *_: None)
    assert not list(tmp_path.iterdir())
