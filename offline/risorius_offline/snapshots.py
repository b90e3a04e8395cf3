"""Solving a sampling design on all cores, resumable.

Samples are solved along short paths, each sample from the nearest one already solved on its path, so that the result
does not depend on how many workers there are. Every finished sample is a small file of its own beside the output,
complete or absent; a run that was stopped, at whatever moment, goes on from them. At the end they become one file.
"""

from __future__ import annotations

import hashlib
import multiprocessing
import os
import shutil
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from risorius.errors import SolverError
from risorius.jaw import FloatArray
from risorius.snapshot_file import SnapshotSet
from risorius.storage import replaced_when_complete, require_folder_of
from risorius_offline.anatomy import Anatomy
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.equilibrium import Equilibrium, EquilibriumSolver
from risorius_offline.full_model import FullModel
from risorius_offline.sampling import SamplingDesign
from risorius_offline.sensitivities import sensitivities

PATH_LENGTH = 4
POLL_SECONDS = 0.3
THREAD_VARIABLES = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")


@dataclass(frozen=True)
class Solved:
    """Result of one sample: displacement (n, 3), its derivatives (p, n, 3), float32, and smallest J, or the failure."""

    u: np.ndarray
    derivatives: np.ndarray
    smallest_jacobian: float
    failure: str


def solve_design(
    anatomy: Anatomy,
    design: SamplingDesign,
    output: Path,
    workers: int,
    progress: Callable[[int, int, int], None],
    effects: EffectChoice | None = None,
) -> SnapshotSet:
    """Solve all samples with `workers` processes and write `output`; calls progress(done, failed, total).

    effects: of the full model, by default none.
    A sample without an equilibrium is listed in `failures` and left out; it never stops the run.
    Raises InputError when the folder of `output` does not exist, SolverError when no sample at all was solved.
    """
    require_folder_of(output)
    effects = effects or EffectChoice()
    folder = _parts_folder(anatomy, design, effects, output)
    folder.mkdir(exist_ok=True)
    anatomy.save(folder / "anatomy.h5")
    _solve_missing(folder, design, effects, workers, progress)
    snapshots = _gather(anatomy, design, effects, folder)
    snapshots.save(output)
    shutil.rmtree(folder)
    return snapshots


def _parts_folder(anatomy: Anatomy, design: SamplingDesign, effects: EffectChoice, output: Path) -> Path:
    """Folder of the finished samples; its name holds what they depend on, so that foreign ones are never taken."""
    digest = hashlib.sha256(anatomy.checksum().encode() + repr(effects).encode() + design.parameters.tobytes())
    return output.with_name(f"{output.name}.parts-{digest.hexdigest()[:12]}")


def _solve_missing(
    folder: Path,
    design: SamplingDesign,
    effects: EffectChoice,
    workers: int,
    progress: Callable[[int, int, int], None],
) -> None:
    total = len(design.parameters)
    paths = [range(start, min(start + PATH_LENGTH, total)) for start in range(0, total, PATH_LENGTH)]
    missing = [path for path in paths if any(_read_part(_part(folder, number)) is None for number in path)]

    def report() -> None:
        progress(len(list(folder.glob("*.npz"))), len(list(folder.glob("*.failed"))), total)

    spawn = multiprocessing.get_context("spawn")
    with _one_thread_each(), ProcessPoolExecutor(workers, spawn, _start_worker, (folder, effects)) as pool:
        pending = {pool.submit(_solve_path, folder, design.parameters, path) for path in missing}
        try:
            report()
            while pending:
                finished, pending = wait(pending, timeout=POLL_SECONDS, return_when=FIRST_COMPLETED)
                for future in finished:
                    future.result()
                report()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in multiprocessing.active_children():
                process.terminate()
            raise


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Child processes inherit one BLAS thread each: workers already fill the cores."""
    before = {name: os.environ.get(name) for name in THREAD_VARIABLES}
    os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


_solver: EquilibriumSolver | None = None


def _start_worker(folder: Path, effects: EffectChoice) -> None:
    global _solver
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _solver = EquilibriumSolver(effects.model(Anatomy.load(folder / "anatomy.h5")))


def _end_with_parent() -> None:
    """End this worker when the run that started it was killed."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
    os._exit(1)


def _solve_path(folder: Path, parameters: FloatArray, path: range) -> None:
    """Solve the samples of a path that are not there yet, and write each."""
    if _solver is None:
        raise SolverError("a worker process was not set up; start the run again, it resumes")
    states = [_solver.rest()]
    for number in path:
        part = _part(folder, number)
        known = _read_part(part)
        if known is None:
            known = _solve_sample(_solver, parameters[number], states)
            _write_part(part, known)
        if not known.failure:
            states.append(Equilibrium(parameters[number], known.u.astype(np.float64)))


def _solve_sample(solver: EquilibriumSolver, parameters: FloatArray, states: list[Equilibrium]) -> Solved:
    """Solve from the nearest known state, and from rest when that fails."""
    distances = [float(np.linalg.norm(state.parameters - parameters)) for state in states]
    failure = ""
    for start in dict.fromkeys((int(np.argmin(distances)), 0)):
        try:
            found = solver.solve(parameters, states[start])
            derivatives = sensitivities(solver.model, found).astype(np.float32)
            return Solved(found.u.astype(np.float32), derivatives, found.report.smallest_jacobian, "")
        except SolverError as error:
            failure = str(error)
    return Solved(np.zeros((0, 3), np.float32), np.zeros((0, 0, 3), np.float32), 0.0, failure)


def _part(folder: Path, number: int) -> Path:
    return folder / f"{number:06d}.npz"


def _write_part(path: Path, solved: Solved) -> None:
    with replaced_when_complete(path) as partial, partial.open("wb") as file:
        np.savez(file, **asdict(solved))
    if solved.failure:
        path.with_suffix(".failed").touch()


def _read_part(path: Path) -> Solved | None:
    try:
        with np.load(path) as data:
            return Solved(data["u"], data["derivatives"], float(data["smallest_jacobian"]), str(data["failure"]))
    except (FileNotFoundError, BadZipFile, EOFError, KeyError, ValueError):
        return None


def _gather(anatomy: Anatomy, design: SamplingDesign, effects: EffectChoice, folder: Path) -> SnapshotSet:
    parts: list[Solved] = []
    for number in range(len(design.parameters)):
        part = _read_part(_part(folder, number))
        if part is None:
            raise SolverError(f"{_part(folder, number)}: vanished or was damaged during the run; start it again")
        parts.append(part)
    solved = [number for number, part in enumerate(parts) if not part.failure]
    if not solved:
        raise SolverError(f"none of the {len(parts)} snapshots could be solved; the first: {parts[0].failure}")
    model = FullModel(anatomy)
    return SnapshotSet(
        name=anatomy.name,
        muscles=anatomy.inputs.muscles,
        poses=anatomy.poses,
        points=anatomy.points,
        skin=anatomy.skin,
        nodal_volumes=model.discretisation.nodal_volumes,
        lift_fields=model.lift_fields,
        parameters=design.parameters[solved],
        displacements=np.stack([parts[number].u for number in solved]),
        derivatives=np.stack([parts[number].derivatives for number in solved]),
        held_out=design.held_out[solved],
        smallest_jacobians=np.array([parts[number].smallest_jacobian for number in solved]),
        failures=tuple(part.failure for part in parts if part.failure),
        provenance={**anatomy.provenance, **effects.provenance(), "risorius": version("risorius")},
    )
