"""Where samples are solved: Dask workers, of this machine or of a running cluster."""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import version

import dask
import numpy as np
import numpy.typing as npt
from distributed import Client, LocalCluster, Worker, WorkerPlugin, get_worker

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.sample import Outcome, SampleSolver, State

CONNECT_SECONDS = 10
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
SETTINGS = {
    "distributed.scheduler.http.routes": [],  # no dashboard
    "distributed.worker.http.routes": [],
    "distributed.nanny.pre-spawn-environ": ONE_THREAD,  # workers already fill the cores
    "distributed.worker.preload": ["import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)"],  # Ctrl-C is for us
    "distributed.worker.profile.enabled": False,  # what nobody looks at takes a part of the cores
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.scheduler.active-memory-manager.start": False,
    "distributed.scheduler.work-stealing-interval": "1s",
    "distributed.scheduler.allowed-failures": 2,  # workers that one sample may end before it is given up
    "distributed.worker.memory.target": False,  # results are a few megabytes: nothing is spilt or paused
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.worker.memory.terminate": False,
}


@contextmanager
def local_cluster(workers: int) -> Iterator[Client]:
    """Worker processes on this machine, one thread each, reachable from this machine only; they end with it."""
    with (
        dask.config.set(SETTINGS),
        LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            worker_dashboard_address="127.0.0.1:0",
            memory_limit=0,
            silence_logs=logging.CRITICAL,
        ) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        yield client


@contextmanager
def running_cluster(address: str) -> Iterator[Client]:
    """Connect to the scheduler of a running cluster; raises InputError when it does not answer."""
    for name in [name for name in logging.root.manager.loggerDict if name.startswith("distributed")]:
        logging.getLogger(name).setLevel(logging.CRITICAL)  # we say ourselves what happens
    try:
        client = Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise InputError(
            f"scheduler {address}: no answer ({error}); start it with `dask scheduler`, and give its tcp:// address"
        ) from error
    with client:
        yield client


class ModelOnWorker(WorkerPlugin):
    """The full model, sent to each worker once, also to those that join later."""

    def __init__(self, name: str, anatomy: Anatomy, effects: EffectChoice, *, derivatives: bool) -> None:
        self.name = name
        self._anatomy, self._effects, self._derivatives = anatomy, effects, derivatives
        self._version = version("risorius")

    def setup(self, worker: Worker) -> None:
        """Prepare for one solver a thread: a solver holds the factors of its last state."""
        self._solvers = threading.local()

    def solver(self) -> SampleSolver:
        """Solver of this thread, made when first asked for; raises InputError for another release of Risorius."""
        if version("risorius") != self._version:
            raise InputError(
                f"worker {get_worker().address} has risorius {version('risorius')}, this run {self._version}; "
                "install the same release there"
            )
        if not hasattr(self._solvers, "solver"):
            model = self._effects.model(self._anatomy)
            self._solvers.solver = SampleSolver(EquilibriumSolver(model), derivatives=self._derivatives)
        return self._solvers.solver


def prepare_worker(name: str) -> None:
    """Put together the solver for the model of that name, which samples would wait for."""
    get_worker().plugins[name].solver()


def solve_on_worker(
    name: str,
    parameters: FloatArray,
    guess: npt.NDArray[np.float32] | None,
    known: tuple[State, ...],
    *before: Outcome,
) -> Outcome:
    """Solve a sample with the model of that name.

    guess: displacement (n, 3) that is to be expected. known, before: what its path has solved so far.
    """
    solver: SampleSolver = get_worker().plugins[name].solver()
    return solver.solve(parameters, guess, [*known, *(outcome.state for outcome in before if outcome.state)])
