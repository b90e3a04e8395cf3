"""Solving a sampling design into a snapshot file, which may hold a part of it already."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from distributed import Client

from risorius.errors import InputError, SolverError
from risorius.snapshot_file import SOLVED, Face
from risorius.snapshot_store import Samples, SnapshotStore, create, opened
from risorius.storage import require_folder_of
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.body import body_of
from risorius_offline.cluster import ModelOnWorker, prepare_worker
from risorius_offline.contact_choice import ContactChoice
from risorius_offline.contact_geometry import contact_geometry
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.leaning import leaning_at_rest
from risorius_offline.one_sided import springs_at_rest
from risorius_offline.paths import Status, solve_waiting

NO_EFFECTS = EffectChoice()
PACKAGES = ("risorius", "numpy", "scipy", "numba", "h5py", "pypardiso", "distributed")


@dataclass(frozen=True)
class FullModelChoice:
    """Which equilibria: of an anatomy with these effects; derivatives: whether to keep those of each, too."""

    anatomy: Anatomy
    effects: EffectChoice = NO_EFFECTS
    derivatives: bool = True

    def settings(self) -> dict[str, Any]:
        """What all snapshots of a file have in common."""
        return {"anatomy": self.anatomy.checksum(), "derivatives": self.derivatives, **self.effects.provenance()}

    def face(self) -> Face:
        """What the file holds beside snapshots."""
        model = self.effects.model(self.anatomy)
        return Face(
            name=self.anatomy.name,
            muscles=self.anatomy.inputs.muscles,
            poses=self.anatomy.poses,
            points=self.anatomy.points,
            surface=self.anatomy.visible_surface,
            companions=self.anatomy.companions,
            nodal_volumes=model.discretisation.nodal_volumes,
            lift_fields=model.lift_fields,
            body=None if self.effects.force_length else body_of(model),
            contact=None if self.effects.contact == ContactChoice.NONE else contact_geometry(self.anatomy),
            leaning=leaning_at_rest(model) if self.derivatives else None,
            springs=springs_at_rest(model),
        )


@dataclass(frozen=True)
class Run:
    """Snapshots to solve into a file.

    shared: settings that a file and a run that goes on with it have in common, beside the full model. wanted: others,
    which the file remembers for a run that is to go on as it was asked for.
    """

    choice: FullModelChoice
    output: Path
    shared: Mapping[str, Any] = field(default_factory=dict)
    wanted: Mapping[str, Any] = field(default_factory=dict)


def solve_design(run: Run, plan: Samples, client: Client, report: Callable[[Status], None]) -> None:
    """Solve all samples of a plan that the file of a run does not hold yet.

    A sample without an equilibrium is recorded with its reason; it never stops the run. Raises InputError when the file
    holds snapshots of something else, SolverError when no sample at all was solved or the scheduler was lost.
    """
    with model_on_workers(client, run.choice) as model, opened_for(run) as store:
        store.add(missing(store, plan))
        solve_waiting(store, client, model, report)
        require_some(store)


@contextmanager
def opened_for(run: Run) -> Iterator[SnapshotStore]:
    """Open the snapshot file of a run, made when there is none; raises InputError when it is one of another run."""
    require_folder_of(run.output)
    settings, provenance = {**run.choice.settings(), **run.shared}, _provenance(run)
    if not run.output.exists():
        create(run.output, run.choice.face(), settings, provenance, derivatives=run.choice.derivatives)
    with opened(run.output) as store:
        for name, value in settings.items():
            if store.settings.get(name) != value:
                raise InputError(
                    f"{run.output}: holds snapshots with {name} = {store.settings.get(name)}, asked for is {value}; "
                    "choose another output, or remove the file"
                )
        versions = store.provenance["versions"]
        new = [entry for entry in provenance["versions"] if entry not in versions]
        store.remember({**store.settings, **run.wanted}, {**store.provenance, "versions": versions + new})
        yield store


@contextmanager
def model_on_workers(client: Client, choice: FullModelChoice) -> Iterator[str]:
    """Send the full model to all workers, of now and later; yield the name that it has there.

    Those of now put it together meanwhile.
    """
    model = f"risorius-{choice.anatomy.checksum()[:12]}-{abs(hash(choice.effects)):x}-{choice.derivatives}"
    plugin = ModelOnWorker(model, choice.anatomy, choice.effects, derivatives=choice.derivatives)
    try:
        client.register_plugin(plugin)
    except ImportError as error:
        raise InputError(
            f"scheduler {client.scheduler.address}: its workers have no module {error.name!r}; install there what is "
            "installed here: pip install 'risorius[offline]'"
        ) from error
    preparing = [client.submit(prepare_worker, model, workers=[worker], pure=False) for worker in client.nthreads()]
    try:
        yield model
    finally:
        if client.status == "running":
            client.cancel(preparing)
            client.unregister_worker_plugin(model)


def missing(store: SnapshotStore, plan: Samples) -> Samples:
    """Samples of a plan that a store does not have."""
    present = {_key(*entry) for entry in zip(store.parameters, store.held_out, strict=True)}
    entries = zip(plan.parameters, plan.held_out, strict=True)
    absent = np.array([_key(*entry) not in present for entry in entries], bool)
    kinds = [kind for kind, wanted in zip(plan.kinds, absent, strict=True) if wanted]
    return Samples(plan.parameters[absent], kinds, plan.held_out[absent], plan.paths[absent])


def require_some(store: SnapshotStore) -> None:
    """Raise SolverError when no sample was solved."""
    if not (store.states == SOLVED).any():
        raise SolverError(
            f"none of the {len(store.states)} snapshots could be solved; the first: {store.failures()[0]}"
        )


def _key(parameters: np.ndarray, held_out: bool) -> tuple[bytes, bool]:
    return (parameters + 0.0).tobytes(), bool(held_out)  # -0.0 is 0.0


def _provenance(run: Run) -> dict[str, Any]:
    versions = {name: found for name in PACKAGES if (found := _installed(name))}
    settings = {**run.choice.settings(), **run.shared}
    return {**run.choice.anatomy.provenance, **settings, "risorius": version("risorius"), "versions": [versions]}


def _installed(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""
