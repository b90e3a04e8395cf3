import numpy as np
from tests.rom.test_training import answer, made_up_snapshots

from risorius.committee import disagreement
from risorius.training import project


def test_maps_disagree_where_nothing_was_learned():
    """Snapshots have weights up to 0.5 only, but for the single actions; the answer has products of the weights."""
    snapshots, fields = made_up_snapshots()
    parameters = snapshots.parameters.copy()
    parameters[5:] *= 0.5
    learned = np.stack([answer(p, fields) for p in parameters]).astype(np.float32)
    noise = np.random.default_rng(1).normal(size=learned.shape).astype(np.float32) * 1e-6  # what a map cannot learn
    noise[:5] = 0.0
    known = type(snapshots)(**{**vars(snapshots), "parameters": parameters, "displacements": learned + noise})
    inside = np.random.default_rng(2).uniform(0.0, 0.5, (50, 5))
    spread = disagreement(known, project(known, 8), np.vstack([inside, 2.0 * inside]))
    assert np.median(spread[50:]) > 3.0 * np.median(spread[:50])
    assert (spread > 0.0).all()
