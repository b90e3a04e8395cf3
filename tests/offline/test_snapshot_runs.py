"""Runs of snapshots as people have them: interrupted, killed, on a cluster whose parts are lost."""

import os
import signal
import time

import numpy as np
import pytest

from risorius.errors import InputError
from risorius.snapshot_file import SnapshotSet
from risorius_offline import cluster
from risorius_offline.cluster import ModelOnWorker, local_cluster, running_cluster
from risorius_offline.paths import solve_waiting
from risorius_offline.snapshots import opened_for, solve_design
from tests.offline.cluster_processes import (
    block_run,
    cluster_processes,
    levels,
    others_of_session,
    started_run,
    wait_until_solved,
)

COUNT = 80  # the last of them start from what the first 64 let expect


def quiet(status):
    pass


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    """Displacements of a run that nothing disturbed, with one worker."""
    path = tmp_path_factory.mktemp("reference") / "s.h5"
    with local_cluster(1) as client:
        solve_design(block_run(path), levels(COUNT), client, quiet)
    return SnapshotSet.load(path).displacements[:]


def finish(path):
    with local_cluster(2) as client:
        solve_design(block_run(path), levels(COUNT), client, quiet)


def require_same(path, reference):
    np.testing.assert_allclose(SnapshotSet.load(path).displacements[:], reference, rtol=0, atol=1e-9)  # a nanometre


def require_nobody_left(run):
    deadline = time.monotonic() + 30
    while others_of_session(run):
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.mark.slow
def test_two_kills_of_the_run_lose_only_what_was_in_work(reference, tmp_path):
    path = tmp_path / "s.h5"
    for count in (8, 24):
        with started_run(tmp_path, "", path, COUNT) as run:
            wait_until_solved(run, count)
            assert others_of_session(run)
            run.kill()
            run.wait()
        require_nobody_left(run)
        assert count <= len(SnapshotSet.load(path).parameters) < COUNT
    finish(path)
    require_same(path, reference)


@pytest.mark.slow
def test_an_interrupt_from_the_keyboard_ends_the_run_and_all_its_workers(reference, tmp_path):
    path = tmp_path / "s.h5"
    with started_run(tmp_path, "", path, COUNT) as run:
        wait_until_solved(run, 8)
        os.killpg(run.pid, signal.SIGINT)  # as a terminal sends it: to the workers, too
        _, said = run.communicate(timeout=60)
    assert run.returncode == 130
    assert "Traceback" not in said
    require_nobody_left(run)
    assert 8 <= len(SnapshotSet.load(path).parameters) < COUNT
    finish(path)
    require_same(path, reference)


def test_a_worker_that_is_killed_halfway_loses_nothing(reference, tmp_path):
    path = tmp_path / "s.h5"
    with cluster_processes(2) as (address, _, workers), started_run(tmp_path, address, path, COUNT) as run:
        wait_until_solved(run, COUNT // 2)
        workers[0].kill()
        _, said = run.communicate(timeout=60)
    assert run.returncode == 0, said
    require_same(path, reference)


@pytest.mark.slow
def test_a_stopped_scheduler_ends_the_run_with_a_file_that_it_goes_on_with(reference, tmp_path):
    path = tmp_path / "s.h5"
    with cluster_processes(2) as (address, scheduler, _), started_run(tmp_path, address, path, COUNT) as run:
        wait_until_solved(run, COUNT // 2)
        scheduler.terminate()
        _, said = run.communicate(timeout=60)
    assert run.returncode == 1
    assert "s.h5: the scheduler was lost; what was finished is kept, start the run again to go on" in said
    assert "Traceback" not in said
    finish(path)
    require_same(path, reference)


def test_a_scheduler_that_is_not_there_is_named(monkeypatch):
    monkeypatch.setattr(cluster, "CONNECT_SECONDS", 0.5)
    with (
        pytest.raises(InputError, match=r"scheduler tcp://127\.0\.0\.1:9: no answer"),
        running_cluster("tcp://127.0.0.1:9"),
    ):
        pass


class Deadly(ModelOnWorker):
    """A model whose solver ends its worker at the second sample of the first path."""

    def solver(self):
        solver = super().solver()

        class Solver:
            def solve(self, parameters, guess, states):
                if parameters[0] == levels(8).parameters[1, 0]:
                    os._exit(1)
                return solver.solve(parameters, guess, states)

        return Solver()


def test_a_sample_that_ends_its_worker_is_given_up_and_the_others_are_solved(tmp_path, monkeypatch):
    monkeypatch.setitem(cluster.SETTINGS, "distributed.scheduler.allowed-failures", 0)
    run = block_run(tmp_path / "s.h5")
    with local_cluster(1) as client, opened_for(run) as store:
        client.register_plugin(Deadly("deadly", run.choice.anatomy, run.choice.effects, derivatives=True))
        store.add(levels(8))
        solve_waiting(store, client, "deadly", quiet)
    found = SnapshotSet.load(run.output)
    assert len(found.parameters) == 7
    assert found.failures == (
        "sample 1 (level): the worker process ended in its solve, 1 times; is memory short there?",
    )


def test_a_worker_of_another_release_is_named(tmp_path):
    run = block_run(tmp_path / "s.h5")
    plugin = ModelOnWorker("other", run.choice.anatomy, run.choice.effects, derivatives=True)
    plugin._version = "0.0.1"
    with local_cluster(1) as client, opened_for(run) as store:
        client.register_plugin(plugin)
        store.add(levels(2))
        with pytest.raises(InputError, match=r"worker tcp://.* has risorius .*, this run 0\.0\.1; install the same"):
            solve_waiting(store, client, "other", quiet)
