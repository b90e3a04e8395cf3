"""Where a learned map is least to be trusted: where maps that saw different snapshots disagree.

Query by committee (Seung, Opper and Sompolinsky 1992).
"""

from __future__ import annotations

import numpy as np

from risorius.evaluators import PolynomialMap
from risorius.jaw import FloatArray
from risorius.one_thread import one_thread
from risorius.snapshot_file import SnapshotSet
from risorius.training import ModalData, overlap

MEMBERS = 4


@one_thread()
def disagreement(snapshots: SnapshotSet, modal: ModalData, candidates: FloatArray) -> FloatArray:
    """Spread (c,) of a committee's answers at candidate parameters (c, p), metres, root mean square over the volume.

    Each member is the learned map without every fourth training snapshot, the single actions excepted.
    """
    singles = snapshots.single_actions()
    shared = overlap(snapshots.displacements[singles])
    others = np.setdiff1d(np.flatnonzero(~snapshots.held_out), singles)
    answers = []
    for member in range(MEMBERS):
        seen = np.concatenate([singles, others[np.arange(len(others)) % MEMBERS != member]])
        learned = PolynomialMap.fit(snapshots.parameters[seen], modal.coordinates[seen], shared)
        answer = np.empty((len(candidates), modal.coordinates.shape[1]))
        for parameters, out in zip(candidates, answer, strict=True):
            learned.coordinates(parameters, out)
        answers.append(answer)
    # One unit of a coordinate is a root mean square displacement of 1 mm.
    return 1e-3 * np.sqrt(np.var(answers, axis=0).sum(axis=1))
