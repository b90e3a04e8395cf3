import numpy as np
import pytest

from risorius.errors import InputError, SolverError
from risorius.mechanics.material import Yeoh
from risorius.snapshot_file import SnapshotSet
from risorius.snapshot_store import Samples, SnapshotStore
from risorius_offline.anatomy.nested_cylinders import nested_cylinders
from risorius_offline.cluster import local_cluster
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel
from risorius_offline.sensitivities import sensitivities
from risorius_offline.snapshots import FullModelChoice, Run, solve_design
from tests.offline.hard_models import dragging, piston
from tests.offline.models import muscle_block


def levels(*values):
    """Samples of a model with one muscle; the last is held out."""
    number = np.arange(len(values))
    return Samples(np.array(values)[:, None], ["level"] * len(values), number == len(values) - 1, number // 4)


@pytest.fixture(scope="module")
def anatomy():
    return muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3))


@pytest.fixture(scope="module")
def two_workers():
    with local_cluster(2) as client:
        yield client


def quiet(status):
    pass


def interrupt_after(count):
    def report(status):
        if status.solved >= count:
            raise KeyboardInterrupt

    return report


def test_snapshots_are_the_equilibria_and_do_not_depend_on_the_workers(anatomy, two_workers, tmp_path):
    plan, choice = levels(1.0, 0.2, 0.4, 0.6, 0.8, 0.9), FullModelChoice(anatomy)
    solve_design(Run(choice, tmp_path / "two.h5"), plan, two_workers, quiet)
    with local_cluster(1) as client:
        solve_design(Run(choice, tmp_path / "one.h5"), plan, client, quiet)
    one, two = SnapshotSet.load(tmp_path / "one.h5"), SnapshotSet.load(tmp_path / "two.h5")
    np.testing.assert_allclose(one.displacements[:], two.displacements[:], rtol=0, atol=1e-9)  # a nanometre
    model = FullModel(anatomy)
    exact = EquilibriumSolver(model, tolerance=1e-11).solve(np.array([0.4]))
    np.testing.assert_allclose(one.displacements[2], exact.u, atol=1e-6 * np.abs(exact.u).max())
    slope = sensitivities(model, exact)
    np.testing.assert_allclose(one.derivatives[2], slope, atol=1e-5 * np.abs(slope).max())
    assert one.held_out.tolist() == [False] * 5 + [True]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["one.h5", "two.h5"]


def test_an_interrupted_run_goes_on_where_it_was(anatomy, two_workers, tmp_path):
    """Early, so that samples are left though workers go on while this process is held up."""
    plan, choice = levels(*np.linspace(1.0, 0.1, 13)), FullModelChoice(anatomy)
    for count in (1, 3):
        with pytest.raises(KeyboardInterrupt):
            solve_design(Run(choice, tmp_path / "s.h5"), plan, two_workers, interrupt_after(count))
        kept = SnapshotSet.load(tmp_path / "s.h5")
        assert count <= len(kept.parameters) < 13
    solve_design(Run(choice, tmp_path / "s.h5"), plan, two_workers, quiet)
    solve_design(Run(choice, tmp_path / "fresh.h5"), plan, two_workers, quiet)
    resumed, fresh = SnapshotSet.load(tmp_path / "s.h5"), SnapshotSet.load(tmp_path / "fresh.h5")
    assert len(resumed.parameters) == 13
    np.testing.assert_allclose(resumed.displacements[:], fresh.displacements[:], rtol=0, atol=1e-9)  # a nanometre
    rows = np.searchsorted(-resumed.parameters[:, 0], -kept.parameters[:, 0])  # what was kept was not solved again
    np.testing.assert_array_equal(kept.displacements[:], resumed.displacements[rows])


def test_each_sample_is_recorded_once(anatomy, two_workers, tmp_path, monkeypatch):
    rows, record = [], SnapshotStore.record
    monkeypatch.setattr(
        SnapshotStore, "record", lambda store, row, solved: rows.append(row) or record(store, row, solved)
    )
    solve_design(
        Run(FullModelChoice(anatomy), tmp_path / "s.h5"), levels(*np.linspace(1.0, 0.1, 10)), two_workers, quiet
    )
    assert sorted(rows) == list(range(10))


def test_a_file_of_another_anatomy_is_refused_and_left_alone(anatomy, two_workers, tmp_path):
    solve_design(Run(FullModelChoice(anatomy), tmp_path / "s.h5"), levels(1.0, 0.5), two_workers, quiet)
    before = (tmp_path / "s.h5").read_bytes()
    other = muscle_block("hexahedron", Yeoh(2600.0, 1175.0, 250e3))
    with pytest.raises(InputError, match=r"holds snapshots with anatomy = .*; choose another output"):
        solve_design(Run(FullModelChoice(other), tmp_path / "s.h5"), levels(1.0, 0.5), two_workers, quiet)
    assert (tmp_path / "s.h5").read_bytes() == before


def test_every_point_of_every_snapshot_keeps_its_orientation(two_workers, tmp_path):
    choice = FullModelChoice(nested_cylinders(), derivatives=False)
    solve_design(Run(choice, tmp_path / "s.h5"), levels(1.0, 0.5, 0.75), two_workers, quiet)
    snapshots, model = SnapshotSet.load(tmp_path / "s.h5"), FullModel(nested_cylinders())
    assert snapshots.derivatives is None
    for u, smallest in zip(snapshots.displacements[:], snapshots.smallest_jacobians, strict=True):
        assert model.point_jacobians(u.astype(np.float64)).min() == pytest.approx(smallest, rel=1e-5)
        assert smallest > 0


def test_a_run_in_which_nothing_can_be_solved_says_so(two_workers, tmp_path):
    """The top of a confined column of 30 mm is pushed down by 40: no state has J > 0."""
    impossible = Samples(np.array([[0.0, 10.0, 0.0]]), ["level"], np.array([False]), np.array([0]))
    choice = FullModelChoice(piston("hexahedron", dragging(along=-0.004)))
    with pytest.raises(SolverError, match=r"none of the 1 snapshots could be solved; the first: .*no equilibrium"):
        solve_design(Run(choice, tmp_path / "s.h5"), impossible, two_workers, quiet)


def test_a_missing_output_folder_is_named_before_anything_is_solved(anatomy, two_workers, tmp_path):
    with pytest.raises(InputError, match=r"the folder .*nowhere does not exist; create it"):
        solve_design(Run(FullModelChoice(anatomy), tmp_path / "nowhere" / "s.h5"), levels(1.0), two_workers, quiet)
    assert not list(tmp_path.iterdir())
