"""Training: from snapshots to a reduced model."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from risorius.bases import pod
from risorius.carried_basis import CarriedBasis
from risorius.errors import InputError
from risorius.evaluators import Evaluator, PolynomialMap, RationalMap, Superposition
from risorius.evaluators.observations import Observations, Reflection
from risorius.jaw import FloatArray
from risorius.modal import modal_derivatives, symmetric_pod
from risorius.model import Accuracy, ReducedModel
from risorius.snapshot_file import BLOCK, SnapshotSet
from risorius.symmetry import mirror_of

COVERAGE = 0.95


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


def reduce_snapshots(snapshots: SnapshotSet, rank: int) -> ReducedModel:
    """Reduced model with at most `rank` POD modes, besides the exact lift fields of the poses.

    Raises InputError when the snapshots lack what training needs.
    """
    return train(snapshots, project(snapshots, rank))


def train(snapshots: SnapshotSet, modal: ModalData) -> ReducedModel:
    """Reduced model of projected snapshots; raises InputError when they lack what training needs."""
    singles = single_actions(snapshots)
    used = ~snapshots.held_out
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
    evaluators: dict[str, Evaluator] = {
        Superposition.name: Superposition(actions),
        PolynomialMap.name: PolynomialMap.fit(observations.parameters, observations.coordinates, shared),
        RationalMap.name: RationalMap.fit(observations),
    }
    surface = snapshots.surface
    fields = np.concatenate([snapshots.lift_fields, modal.modes])
    basis = surface.carry(fields)
    model = ReducedModel(
        name=snapshots.name,
        inputs=snapshots.inputs,
        poses=snapshots.poses,
        rest_vertices=surface.points.astype(np.float32),
        triangles=surface.triangles.astype(np.int32),
        carried_basis=CarriedBasis.of_surface(surface, fields),
        evaluators=evaluators,
        accuracy={name: _accuracy(evaluators, name, snapshots, basis) for name in evaluators},
        provenance={**snapshots.provenance, "snapshots": int(used.sum()), "held_out": int((~used).sum())},
        colours=surface.colours,
        companions=snapshots.companions,
    )
    return model


def single_actions(snapshots: SnapshotSet) -> npt.NDArray[np.int64]:
    """Snapshot number of every single parameter at weight 1."""
    rows = []
    for number, name in enumerate(snapshots.inputs.parameters):
        wanted = np.zeros(snapshots.parameters.shape[1])
        wanted[number] = 1.0
        found = np.flatnonzero((snapshots.parameters == wanted).all(axis=1) & ~snapshots.held_out)
        if not len(found):
            raise InputError(f"snapshots: {name} alone at weight 1 is missing (unsolved?); superposition needs it")
        rows.append(int(found[0]))
    return np.array(rows)


def project(snapshots: SnapshotSet, rank: int) -> ModalData:
    """POD modes of the training snapshots, at most `rank`, and the coordinates of all snapshots in them.

    On a symmetric face also of their mirror images. Displacements are read a block at a time. Raises InputError for a
    rank below 1, or without training snapshots or one of the single actions.
    """
    if rank < 1:
        raise InputError(f"rank {rank}: give at least 1")
    if snapshots.held_out.all():
        raise InputError("snapshots: all are held out, there is none to train with; solve some")
    train = np.flatnonzero(~snapshots.held_out)
    mirror = mirror_of(snapshots, single_actions(snapshots))
    reflection = None
    if mirror is None:
        modes, _ = pod(lambda: _fluctuations(snapshots, train), snapshots.nodal_volumes, rank)
    else:
        modes, parity = symmetric_pod(lambda: _fluctuations(snapshots, train), snapshots.nodal_volumes, rank, mirror)
        reflection = Reflection(mirror.partner, mirror.sign, parity)
    # One unit of a coordinate is a root mean square displacement of 1 mm.
    modes *= 1e-3 * np.sqrt(snapshots.nodal_volumes.sum())
    weighted = modes * snapshots.nodal_volumes[:, None] / (1e-6 * snapshots.nodal_volumes.sum())
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


def _accuracy(evaluators: dict[str, Evaluator], name: str, snapshots: SnapshotSet, basis: FloatArray) -> Accuracy:
    """Errors of the visible vertices on the held-out snapshots, and the calibration of every frame's error bound."""
    held = np.flatnonzero(snapshots.held_out)
    if not len(held):
        raise InputError("snapshots: none is held out, the model's accuracy cannot be measured; solve some")
    rank = len(basis) - len(snapshots.lift_fields)
    errors = np.empty((len(held), basis.shape[1]), np.float32)
    sizes, lengths = np.empty(len(held)), np.empty(len(held))
    modal, linear = np.empty(rank), np.zeros(rank)
    lifts = _lifts(snapshots)[held]
    for row, parameters in enumerate(snapshots.parameters[held]):
        evaluators[name].coordinates(parameters, modal)
        if name != Superposition.name:
            evaluators[Superposition.name].coordinates(parameters, linear)
        u = np.tensordot(np.concatenate([lifts[row], modal]), basis, axes=1)
        truth = snapshots.surface.weights @ snapshots.displacements[held[row]].astype(np.float64)
        errors[row] = np.linalg.norm(u - truth, axis=1)
        lengths[row] = np.linalg.norm(truth)
        sizes[row] = np.linalg.norm(modal - linear)
    offset = 0.1 * float(np.median(sizes)) + 1e-12
    worst = errors.max(axis=1).astype(np.float64)
    slope = _conformal_quantile(worst / (sizes + offset))
    relative = np.linalg.norm(errors, axis=1) / lengths
    return Accuracy(
        mean=float(errors.mean()),
        p95=float(np.quantile(errors, 0.95)),
        maximum=float(errors.max()),
        relative=float(np.median(relative)),
        error_floor=slope * offset,
        error_slope=slope,
        coverage=float((worst <= slope * (sizes + offset)).mean()),
    )


def _conformal_quantile(scores: FloatArray) -> float:
    """Smallest score that covers a new one with probability COVERAGE, given exchangeable scores (Vovk et al. 2005)."""
    position = int(np.ceil((len(scores) + 1) * COVERAGE))
    return float(np.sort(scores)[min(position, len(scores)) - 1])
