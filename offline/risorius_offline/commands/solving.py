"""What `risorius snapshots` and `risorius train` share: from options to a snapshot file."""

from __future__ import annotations

import os
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, replace
from pathlib import Path

from distributed import Client

from risorius.commands.reduce import DEFAULT_RANK
from risorius.errors import InputError
from risorius.snapshot_file import SnapshotSet, stored_settings
from risorius.snapshot_store import Samples
from risorius.storage import require_folder_of
from risorius_offline.adaptive import Goal, refine
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.cluster import local_cluster, running_cluster
from risorius_offline.commands.cost import show_cost
from risorius_offline.commands.progress import Display, display
from risorius_offline.commands.run_options import RunOptions
from risorius_offline.commands.source import load
from risorius_offline.contact_choice import ContactChoice
from risorius_offline.cost import estimate
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.paths import solve_waiting
from risorius_offline.sampling import DESIGN, design
from risorius_offline.snapshots import FullModelChoice, Run, missing, model_on_workers, opened_for, require_some

# Of an adaptive run: the first half is the design's, so that there is something to learn from.
SHARE_OF_DESIGN = 0.5


def solve(
    source: str, output: Path, options: RunOptions, workers: int, scheduler: str | None, *, json_lines: bool
) -> SnapshotSet:
    """Solve, write and return the snapshots of a source, with a display of progress; failures are listed at the end."""
    with display(json_lines) as shown:
        shown.prepare(f"the anatomy {source}")
        anatomy = load(source)
        shown.prepare("the full model")
        with _cluster(workers, scheduler) as client:
            failures = _solve(run_of(anatomy, output, options), options, client, shown)
        snapshots = SnapshotSet.load(output)
        shown.finish(output, len(snapshots.parameters), failures)
    return snapshots


def show_estimate(
    source: str, output: Path, options: RunOptions, workers: int, scheduler: str | None, *, json_lines: bool
) -> None:
    """Tell what a run would take, from one solve here. Nothing is written."""
    anatomy = load(source)
    require_folder_of(output)
    with running_cluster(scheduler) if scheduler else nullcontext() as client:
        cores = sum(client.nthreads().values()) if client else workers or _cores()
    show_cost(estimate(run_of(anatomy, output, options), _plan(anatomy, options), cores), json_lines=json_lines)


def run_of(anatomy: Anatomy, output: Path, options: RunOptions) -> Run:
    """Run of these options."""
    effects = EffectChoice(contact=options.contact, prestress=options.prestress, force_length=options.force_length)
    choice = FullModelChoice(anatomy, effects, options.derivatives)
    return Run(choice, output, {"seed": options.seed, "design": DESIGN}, {"options": asdict(options)})


def stored_options(output: Path) -> RunOptions:
    """Return what a snapshot file was asked for; raises InputError when it does not say."""
    options = stored_settings(output).get("options")
    if options is None:
        raise InputError(f"{output}: was not made by `risorius snapshots`; give its options instead of --resume")
    return RunOptions(**{**options, "contact": ContactChoice(options["contact"])})


def _solve(run: Run, options: RunOptions, client: Client, shown: Display) -> list[str]:
    """Return why samples could not be solved."""
    anatomy = run.choice.anatomy
    first = replace(options, count=round(SHARE_OF_DESIGN * options.count)) if options.adaptive else options
    with model_on_workers(client, run.choice) as model, opened_for(run) as store:
        store.add(missing(store, _plan(anatomy, first)))
        if options.adaptive:
            goal = Goal(
                max(options.count, len(anatomy.inputs.parameters)),
                1e-3 * options.target_error,
                DEFAULT_RANK,
                options.seed,
            )
            refine(store, client, model, shown.show, goal)
        else:
            solve_waiting(store, client, model, shown.show)
        require_some(store)
        return store.failures()


def _plan(anatomy: Anatomy, options: RunOptions) -> Samples:
    return design(anatomy.inputs, options.count, options.held_out, options.seed)


def _cluster(workers: int, scheduler: str | None) -> AbstractContextManager[Client]:
    if scheduler:
        return running_cluster(scheduler)
    return local_cluster(workers or _cores())


def _cores() -> int:
    return len(os.sched_getaffinity(0))
