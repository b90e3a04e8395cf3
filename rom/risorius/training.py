"""Training: from snapshots to a reduced model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from risorius.bases import pod
from risorius.errors import InputError
from risorius.evaluators import Evaluator, PolynomialMap, Superposition
from risorius.jaw import FloatArray
from risorius.model import Accuracy, ReducedModel
from risorius.snapshot_file import SnapshotSet

COVERAGE = 0.95


@dataclass(frozen=True)
class _ModalData:
    """Snapshots in the basis: modes on all nodes (r, n, 3) and modal coordinates (s, r)."""

    modes: FloatArray
    coordinates: FloatArray


def reduce_snapshots(snapshots: SnapshotSet, rank: int) -> ReducedModel:
    """Reduced model with at most `rank` POD modes, besides the exact lift fields of the poses.

    Raises InputError when the snapshots lack what training needs.
    """
    if rank < 1:
        raise InputError(f"rank {rank}: give at least 1")
    singles = _single_actions(snapshots)
    modal = _project(snapshots, rank)
    train = ~snapshots.held_out
    parameters = snapshots.parameters
    evaluators: dict[str, Evaluator] = {
        Superposition.name: Superposition(modal.coordinates[singles]),
        PolynomialMap.name: PolynomialMap.fit(
            parameters[train], modal.coordinates[train], _overlap(snapshots.displacements[singles])
        ),
    }
    skin_nodes, triangles = np.unique(snapshots.skin, return_inverse=True)
    basis = np.concatenate([snapshots.lift_fields, modal.modes])[:, skin_nodes]
    model = ReducedModel(
        name=snapshots.name,
        inputs=snapshots.inputs,
        poses=snapshots.poses,
        rest_vertices=snapshots.points[skin_nodes].astype(np.float32),
        triangles=triangles.reshape(snapshots.skin.shape).astype(np.int32),
        basis=np.ascontiguousarray(basis, dtype=np.float32),
        evaluators=evaluators,
        accuracy={name: _accuracy(evaluators, name, snapshots, basis, skin_nodes) for name in evaluators},
        provenance={**snapshots.provenance, "snapshots": int(train.sum()), "held_out": int((~train).sum())},
    )
    return model


def _single_actions(snapshots: SnapshotSet) -> npt.NDArray[np.int64]:
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


def _project(snapshots: SnapshotSet, rank: int) -> _ModalData:
    fluctuations = snapshots.displacements.astype(np.float64)
    fluctuations -= np.tensordot(_lifts(snapshots), snapshots.lift_fields, axes=1)
    modes, _ = pod(fluctuations[~snapshots.held_out], snapshots.nodal_volumes, rank)
    # One unit of a coordinate is a root mean square displacement of 1 mm.
    modes *= 1e-3 * np.sqrt(snapshots.nodal_volumes.sum())
    squared = float(1e-6 * snapshots.nodal_volumes.sum())
    coordinates = np.einsum("sni,n,rni->sr", fluctuations, snapshots.nodal_volumes, modes, optimize=True) / squared
    return _ModalData(modes, coordinates)


def _lifts(snapshots: SnapshotSet) -> FloatArray:
    """Lift coordinates (s, lifts) of every snapshot."""
    weights = snapshots.parameters[:, len(snapshots.muscles) :]
    return np.stack([snapshots.poses.lift_coordinates(row) for row in weights])


def _overlap(displacements: npt.NDArray[np.float32]) -> FloatArray:
    """(p, p) cosine between the displacement magnitudes (p, n, 3) of single actions: 1 where they move the same."""
    magnitude = np.linalg.norm(displacements.astype(np.float64), axis=2)
    magnitude /= np.linalg.norm(magnitude, axis=1, keepdims=True)
    return magnitude @ magnitude.T


def _accuracy(
    evaluators: dict[str, Evaluator], name: str, snapshots: SnapshotSet, basis: FloatArray, skin: npt.NDArray[np.int64]
) -> Accuracy:
    """Errors on the held-out snapshots, and the calibration of the error bound that every frame carries."""
    held = np.flatnonzero(snapshots.held_out)
    if not len(held):
        raise InputError("snapshots: none is held out, the model's accuracy cannot be measured; solve some")
    truth = snapshots.displacements[held][:, skin].astype(np.float64)
    rank = len(basis) - len(snapshots.lift_fields)
    errors, sizes = np.empty((len(held), len(skin))), np.empty(len(held))
    modal, linear = np.empty(rank), np.zeros(rank)
    lifts = _lifts(snapshots)[held]
    for row, parameters in enumerate(snapshots.parameters[held]):
        evaluators[name].coordinates(parameters, modal)
        if name != Superposition.name:
            evaluators[Superposition.name].coordinates(parameters, linear)
        u = np.tensordot(np.concatenate([lifts[row], modal]), basis, axes=1)
        errors[row] = np.linalg.norm(u - truth[row], axis=1)
        sizes[row] = np.linalg.norm(modal - linear)
    offset = 0.1 * float(np.median(sizes)) + 1e-12
    worst = errors.max(axis=1)
    slope = _conformal_quantile(worst / (sizes + offset))
    relative = np.linalg.norm(errors, axis=1) / np.linalg.norm(truth, axis=(1, 2))
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
