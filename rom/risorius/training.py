"""Training: from snapshots to a reduced model."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from risorius.accuracy import HeldOut
from risorius.bases import pod
from risorius.carried_basis import CarriedBasis
from risorius.effects import EFFECTS, Effect
from risorius.errors import InputError
from risorius.evaluators import CorrectedMap, Evaluator, PolynomialMap, RationalMap, Superposition
from risorius.evaluators.network import NetworkMap
from risorius.evaluators.network_fit import fit_network
from risorius.evaluators.observations import Observations, Reflection
from risorius.guard.watch import Watch, random_states
from risorius.hyper_reduction.sampled_body import Equilibria, SampledBody, sample_body
from risorius.jaw import FloatArray
from risorius.measuring import measured, settings
from risorius.mechanics.body import Body
from risorius.modal import directional_derivatives, modal_derivatives, symmetric_pod, visible_measure
from risorius.model import ReducedModel
from risorius.one_thread import one_thread
from risorius.snapshot_file import BLOCK, SnapshotSet
from risorius.symmetry import mirror_of
from risorius.training_stages import UNTOLD, Stages

ELEMENTS = 400  # of the corrected map
USUAL = ("single", "ramp", "expression")  # kinds of snapshots that the map has to meet


@dataclass(frozen=True)
class ModalData:
    """Snapshots in the basis: modes on all nodes (r, n, 3) and modal coordinates (s, r).

    derivatives (t, p, r) of those of the training snapshots by the parameters, None where they were not kept;
    reflection: None where the face is not symmetric.
    """

    modes: FloatArray
    coordinates: FloatArray
    derivatives: npt.NDArray[np.float32] | None
    reflection: Reflection | None


def reduce_snapshots(
    snapshots: SnapshotSet, rank: int, coarse: ReducedModel | None = None, stages: Stages = UNTOLD
) -> ReducedModel:
    """Reduced model with at most `rank` POD modes, besides the exact lift fields of the poses.

    coarse: of a coarser mesh of the same face, trained from more snapshots, whose network this one's begins from.
    stages: are told what is at work.
    Raises InputError when the snapshots lack what training needs, or the coarse model is of another face.
    """
    begin = time.process_time()
    known, told = None, dict[str, Any]()
    if coarse is not None:
        known = _network_of(coarse, snapshots)
        told["coarse"] = f"{coarse.name}, {coarse.provenance.get('snapshots', '?')} snapshots"
    stages.begin("modes")
    model = train(snapshots, project(snapshots, rank), known, stages)
    told["training_cpu_seconds"] = time.process_time() - begin
    return replace(model, provenance={**model.provenance, **told})


@one_thread()
def train(
    snapshots: SnapshotSet, modal: ModalData, known: NetworkMap | None = None, stages: Stages = UNTOLD
) -> ReducedModel:
    """Reduced model of projected snapshots, whose network begins from one that is known of the same face.

    Raises InputError when the snapshots lack what training needs.
    """
    evaluators, learned = _maps(snapshots, modal, known, stages)
    fields = np.concatenate([snapshots.lift_fields, modal.modes])
    watch = None
    if snapshots.body is not None:
        stages.begin("reduced physics")
        sampled = _sample(snapshots, snapshots.body, modal, fields)
        evaluators[CorrectedMap.name] = CorrectedMap(learned, sampled, snapshots.poses)
        stages.begin("points to watch")
        watch = _watch(snapshots, snapshots.body, modal, fields, learned)
    used, surface = ~snapshots.held_out, snapshots.surface
    sizes = np.sqrt(np.square(modal.coordinates[used]).mean(axis=0))
    sizes = np.concatenate([np.ones(len(snapshots.lift_fields)), sizes])
    model = ReducedModel(
        name=snapshots.name,
        inputs=snapshots.inputs,
        poses=snapshots.poses,
        rest_vertices=surface.points.astype(np.float32),
        triangles=surface.triangles.astype(np.int32),
        carried_basis=CarriedBasis.of_surface(surface, fields).rounded_off(sizes),
        evaluators=evaluators,
        points=(),
        provenance={**snapshots.provenance, "snapshots": int(used.sum()), "held_out": int((~used).sum())},
        colours=surface.colours,
        companions=snapshots.companions,
        watch=watch,
        effects=dict(_effects(snapshots, fields, stages)),
    )
    stages.begin("errors and times")
    return replace(model, points=measured(model, HeldOut.of(snapshots), settings(model)))


def _maps(
    snapshots: SnapshotSet, modal: ModalData, known: NetworkMap | None, stages: Stages
) -> tuple[dict[str, Evaluator], RationalMap | NetworkMap]:
    """Evaluators by name that need no physics, and the best of them."""
    singles, used = snapshots.single_actions(), ~snapshots.held_out
    actions, shared = modal.coordinates[singles], overlap(snapshots.displacements[singles])
    observations = Observations(
        parameters=snapshots.parameters[used],
        coordinates=modal.coordinates[used],
        derivatives=modal.derivatives,
        muscles=len(snapshots.muscles),
        lowest=snapshots.inputs.parameter_lower,
        overlap=shared,
        sizes=np.linalg.norm(actions, axis=1),
        reflection=modal.reflection,
    )
    stages.begin("polynomial map")
    polynomial = PolynomialMap.fit(observations.parameters, observations.coordinates, shared)
    stages.begin("rational map")
    rational = RationalMap.fit(observations)
    learned: RationalMap | NetworkMap = rational
    if modal.derivatives is not None:
        stages.begin("network")
        usual = np.flatnonzero(np.isin(np.array(snapshots.kinds)[used], USUAL))
        learned = fit_network(observations, known, stages.reached).completed(observations.only(usual))
    maps: tuple[Evaluator, ...] = (Superposition(actions), polynomial, rational, learned)
    return {one.name: one for one in maps}, learned


def _effects(snapshots: SnapshotSet, fields: FloatArray, stages: Stages) -> Iterator[tuple[str, Effect]]:
    """Name and effect, of those that the snapshots tell of."""
    for name, kind in EFFECTS.items():
        stages.begin(name)
        if found := kind.train(snapshots, fields):
            yield name, found


def _network_of(coarse: ReducedModel, snapshots: SnapshotSet) -> NetworkMap:
    """The network of a model of the same face; raises InputError where there is none, or the face is another one."""
    network = coarse.evaluators.get(NetworkMap.name)
    if not isinstance(network, NetworkMap):
        raise InputError(f"coarse: model '{coarse.name}' has no network; train it from snapshots with derivatives")
    if snapshots.derivatives is None:
        raise InputError("snapshots: have no derivatives, without which nothing can be learned from a coarse model")
    ours, theirs = snapshots.inputs.parameters, coarse.inputs.parameters
    if ours != theirs:
        raise InputError(
            f"coarse: model '{coarse.name}' has other muscles or poses, or in another order "
            f"({', '.join(sorted(set(ours) ^ set(theirs))) or 'the same names'}); give one of the same face"
        )
    return network


def _sample(snapshots: SnapshotSet, body: Body, modal: ModalData, fields: FloatArray) -> SampledBody:
    """Reduce the physics of the face to few elements, for the coordinates of fields (r, n, 3)."""
    used = ~snapshots.held_out
    equilibria = Equilibria(
        activations=snapshots.parameters[used, : len(snapshots.muscles)],
        states=np.hstack([_lifts(snapshots), modal.coordinates])[used],
    )
    return sample_body(body, snapshots.points, fields, len(snapshots.lift_fields), equilibria, ELEMENTS)


def _watch(snapshots: SnapshotSet, body: Body, modal: ModalData, fields: FloatArray, learned: Evaluator) -> Watch:
    """Choose where the engine looks for folded tissue, from snapshots and from what a map makes of random inputs."""
    equilibria = np.hstack([_lifts(snapshots), modal.coordinates])[~snapshots.held_out]
    others = random_states(learned, snapshots.inputs, snapshots.poses, len(modal.modes))
    return Watch.choose(body, snapshots.points, fields, len(snapshots.lift_fields), equilibria, others)


@one_thread()
def project(snapshots: SnapshotSet, rank: int) -> ModalData:
    """POD modes of the training snapshots, at most `rank`, and the coordinates of all snapshots in them.

    Modes are made for what is seen, and for how snapshots change with the parameters; on a symmetric face for mirror
    images, too. Displacements are read a block at a time. Raises InputError for a rank below 1, or without training
    snapshots or one of the single actions.
    """
    if rank < 1:
        raise InputError(f"rank {rank}: give at least 1")
    if snapshots.held_out.all():
        raise InputError("snapshots: all are held out, there is none to train with; solve some")
    train = np.flatnonzero(~snapshots.held_out)
    mirror = mirror_of(snapshots, snapshots.single_actions())
    measure, neighbours = visible_measure(snapshots), directional_derivatives(snapshots, train)

    def seen() -> Iterator[FloatArray]:
        yield from _fluctuations(snapshots, train)
        for start in range(0, len(neighbours), BLOCK):
            yield neighbours[start : start + BLOCK].astype(np.float64)

    reflection = None
    if mirror is None:
        modes, _ = pod(seen, measure, rank)
    else:
        modes, parity = symmetric_pod(seen, measure, rank, mirror)
        reflection = Reflection(mirror.partner, mirror.sign, parity)
    modes *= 1e-3  # one unit of a coordinate is a root mean square displacement of 1 mm
    weighted = modes * measure[:, None] / 1e-6
    blocks = _fluctuations(snapshots, np.arange(len(snapshots.parameters)))
    coordinates = np.concatenate([np.tensordot(block, weighted, ((1, 2), (1, 2))) for block in blocks])
    return ModalData(modes, coordinates, modal_derivatives(snapshots, train, weighted), reflection)


def _fluctuations(snapshots: SnapshotSet, rows: npt.NDArray[np.int64]) -> Iterator[FloatArray]:
    """Displacements (b, n, 3) less what the poses prescribe, block after block: all of them may not fit in memory."""
    lifts = _lifts(snapshots)
    for start in range(0, len(rows), BLOCK):
        block = rows[start : start + BLOCK]
        prescribed = np.tensordot(lifts[block], snapshots.lift_fields, axes=1)
        yield snapshots.displacements[block].astype(np.float64) - prescribed


def _lifts(snapshots: SnapshotSet) -> FloatArray:
    """Lift coordinates (s, lifts) of every snapshot."""
    weights = snapshots.parameters[:, len(snapshots.muscles) :]
    return np.stack([snapshots.poses.lift_coordinates(row) for row in weights])


def overlap(displacements: npt.NDArray[np.float32]) -> FloatArray:
    """(p, p) cosine between the displacement magnitudes (p, n, 3) of single actions: 1 where they move the same."""
    magnitude = np.linalg.norm(displacements.astype(np.float64), axis=2)
    magnitude /= np.linalg.norm(magnitude, axis=1, keepdims=True)
    return magnitude @ magnitude.T
