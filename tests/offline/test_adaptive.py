import numpy as np
import pytest

from risorius.mechanics.material import Yeoh
from risorius.operating_point import most_accurate
from risorius.snapshot_file import SnapshotSet
from risorius.training import reduce_snapshots
from risorius_offline.adaptive import KIND, Goal, _worst, refine
from risorius_offline.cluster import local_cluster
from risorius_offline.sampling import design
from risorius_offline.snapshots import FullModelChoice, Run, model_on_workers, opened_for, solve_design
from tests.offline.models import muscle_block


@pytest.fixture(scope="module")
def worker():
    with local_cluster(1) as client:
        yield client


@pytest.fixture
def run(tmp_path):
    return Run(FullModelChoice(muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3))), tmp_path / "s.h5")


def refined(run, client, goal):
    told = []
    with model_on_workers(client, run.choice) as model, opened_for(run) as store:
        if not len(store.parameters):
            store.add(design(run.choice.anatomy.inputs, 8, 4, goal.seed))
        error = refine(store, client, model, told.append, goal)
    return error, told


def test_snapshots_are_added_up_to_the_count_and_the_error_is_told(run, worker):
    error, told = refined(run, worker, Goal(count=20, error=0.0, rank=5, seed=0))
    found = SnapshotSet.load(run.output)
    assert (~found.held_out).sum() == 20
    assert found.kinds.count(KIND) == 12
    assert len(np.unique(found.parameters, axis=0)) == 24
    assert told[-1].total == 24
    assert told[-1].error is not None
    assert error == most_accurate(reduce_snapshots(found, 5).points).overall.p95


def test_a_target_that_is_reached_ends_it(run, worker):
    error, _ = refined(run, worker, Goal(count=1000, error=1.0, rank=5, seed=0))
    assert error < 1.0
    assert len(SnapshotSet.load(run.output).parameters) == 12


def test_samples_of_the_design_do_not_depend_on_what_was_added(run, worker, tmp_path):
    refined(run, worker, Goal(count=12, error=0.0, rank=5, seed=0))
    longer = design(run.choice.anatomy.inputs, 24, 4, 0)
    solve_design(run, longer, worker, lambda _: None)
    plain = Run(run.choice, tmp_path / "plain.h5")
    solve_design(plain, longer, worker, lambda _: None)
    found, fresh = SnapshotSet.load(run.output), SnapshotSet.load(plain.output)
    number = {row.tobytes(): k for k, row in enumerate(found.parameters)}
    rows = [number[row.tobytes()] for row in fresh.parameters]
    chosen = {k for k, kind in enumerate(found.kinds) if kind == KIND}  # candidates are samples of the longer design
    same = [k for k, row in enumerate(rows) if row not in chosen]
    np.testing.assert_allclose(
        found.displacements[:][np.array(rows)[same]], fresh.displacements[:][same], rtol=0, atol=1e-9
    )


def test_a_round_takes_the_largest_spread_and_keeps_its_distance():
    candidates = np.array([[0.0], [0.9], [0.91], [0.4]])
    assert _worst(np.array([0.1, 1.0, 0.99, 0.5]), candidates, 2) == [1, 3]
