"""Modes of what is seen, of both sides and of how snapshots change; and derivatives in them, for the learned map."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import numpy.typing as npt

from risorius.bases import pod
from risorius.jaw import FloatArray
from risorius.snapshot_file import SnapshotSet
from risorius.symmetry import Mirror

VISIBLE_SHARE = 0.9  # of the measure of errors; the rest is tissue that only physics sees
# Directional derivatives stand for snapshots a little way off: length of the way in every parameter, and how many.
STEP = 0.03
MOST_NEIGHBOURS = 1200
BLOCK = 8  # snapshots whose derivatives are read at once: 60 of 100 000 components of each take 200 MB


def visible_measure(snapshots: SnapshotSet) -> FloatArray:
    """Share (n,) of each node in the mean square displacement that modes are made for; they add up to 1.

    Of what is seen each node has its weights in the visible vertices, of the tissue its volume.
    """
    visible = np.asarray(abs(snapshots.surface.weights).sum(axis=0)).ravel()
    volumes = snapshots.nodal_volumes
    return VISIBLE_SHARE * visible / visible.sum() + (1.0 - VISIBLE_SHARE) * volumes / volumes.sum()


def directional_derivatives(snapshots: SnapshotSet, rows: npt.NDArray[np.int64]) -> npt.NDArray[np.float32]:
    """Derivatives of displacements in random directions, (k, n, 3), a STEP long; none where snapshots have none.

    Each direction goes STEP up or down in every parameter, so that the squares of a snapshot's derivatives add up in
    the mean to those of all its parameters. At most MOST_NEIGHBOURS, from evenly chosen snapshots. What the poses
    prescribe is not part of them.
    """
    nodes, muscles = len(snapshots.points), len(snapshots.muscles)
    if snapshots.derivatives is None:
        return np.zeros((0, nodes, 3), np.float32)
    each = max(MOST_NEIGHBOURS // len(rows), 1)
    rows = rows[:: -(-len(rows) // MOST_NEIGHBOURS)]
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (len(rows), each, snapshots.parameters.shape[1]))
    ways = (STEP / np.sqrt(each) * signs).astype(np.float32)
    result = np.empty((len(rows), each, nodes, 3), np.float32)
    for out, row, way in zip(result, rows, ways, strict=True):
        slopes = snapshots.poses.lift_slopes(snapshots.parameters[row, muscles:])
        prescribed = np.tensordot(way[:, muscles:] @ slopes, snapshots.lift_fields, axes=1)
        out[:] = np.tensordot(way, snapshots.derivatives[row], axes=1) - prescribed
    return result.reshape(-1, nodes, 3)


def symmetric_pod(
    blocks: Callable[[], Iterable[FloatArray]], weights: FloatArray, rank: int, mirror: Mirror
) -> tuple[FloatArray, FloatArray]:
    """Modes (r, n, 3) of snapshots and their mirror images, and the parity (r,) of each: 1 symmetric, -1 opposite.

    Symmetric and antisymmetric parts are orthogonal, so that the POD of both together is that of each, the larger
    singular values first.
    """

    def part(parity: float) -> Callable[[], Iterable[FloatArray]]:
        return lambda: (0.5 * (block + parity * mirror.image(block)) for block in blocks())

    modes, singular, parity = [], [], []
    for sign in (1.0, -1.0):
        fields, values = pod(part(sign), weights, rank)
        modes.append(fields)
        singular.append(values)
        parity.append(np.full(len(values), sign))
    largest = np.argsort(-np.concatenate(singular), kind="stable")[:rank]
    return np.concatenate(modes)[largest], np.concatenate(parity)[largest]


def modal_derivatives(
    snapshots: SnapshotSet, rows: npt.NDArray[np.int64], weighted: FloatArray
) -> npt.NDArray[np.float32] | None:
    """Derivatives (rows, p, r) of the coordinates by the parameters, None where snapshots have none.

    weighted: (r, n, 3), with which a displacement is multiplied to give its coordinates. What the poses prescribe is
    not part of them.
    """
    if snapshots.derivatives is None:
        return None
    flat = weighted.reshape(len(weighted), -1).T
    single = flat.astype(np.float32)
    prescribed = snapshots.lift_fields.reshape(-1, len(flat)) @ flat
    muscles = len(snapshots.muscles)
    result = np.empty((len(rows), snapshots.parameters.shape[1], len(weighted)), np.float32)
    for start in range(0, len(rows), BLOCK):
        block = rows[start : start + BLOCK]
        fields = snapshots.derivatives[block]
        result[start : start + BLOCK] = fields.reshape(*fields.shape[:2], -1) @ single
    for number, row in enumerate(rows):
        result[number, muscles:] -= snapshots.poses.lift_slopes(snapshots.parameters[row, muscles:]) @ prescribed
    return result
