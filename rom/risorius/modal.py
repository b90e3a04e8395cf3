"""What more than coordinates the learned map is fitted to: modes of both sides, and derivatives in them."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import numpy.typing as npt

from risorius.bases import pod
from risorius.jaw import FloatArray
from risorius.snapshot_file import SnapshotSet
from risorius.symmetry import Mirror

BLOCK = 8  # snapshots whose derivatives are read at once: 60 of 100 000 components of each take 200 MB


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
