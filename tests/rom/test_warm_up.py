"""No frame waits for a kernel to be compiled: whatever it may call for was done when the engine was made."""

import gc
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from numba.core.dispatcher import Dispatcher

import risorius
from risorius.effects import Touch
from risorius.guard import Watch


@pytest.fixture
def model_with_everything(synthetic_model, lively_model, walled_model, tmp_path):
    """File of a model with all effects, whose tissue folds where a modal coordinate comes to 0.1."""
    gradients = np.zeros((synthetic_model.rank, 6, 9), np.float32)
    gradients[synthetic_model.lifts + np.arange(6), np.arange(6), 0] = -10.0
    watch = Watch(gradients, longest=3.0, places=np.zeros((6, 3)))
    model = replace(synthetic_model, effects={**lively_model.effects, **walled_model.effects}, watch=watch)
    model.save(tmp_path / "model.h5")
    return tmp_path / "model.h5"


def signatures():
    """Number of compiled signatures of each kernel."""
    kernels = (one for one in gc.get_objects() if isinstance(one, Dispatcher))
    return {f"{one.py_func.__module__}.{one.py_func.__qualname__}": len(one.signatures) for one in kernels}


def hard_frames(path):
    """Methods of frames that call for everything, and the kernels that they compile in a process of their own."""
    engine = risorius.Engine(risorius.load(path))
    before = signatures()
    frames = [
        engine.evaluate({"AU12": 0.05}),
        engine.evaluate({"AU12": 1.0}),
        engine.evaluate({"jaw_open": 1.0}),
        engine.evaluate(np.full(len(engine.inputs), 0.5)),
        *(engine.evaluate({"AU12": 1.0, "jaw_open": 0.3}, step=step) for step in (1e-3, 1e-2, 1e-1)),
        engine.evaluate({"AU12": 0.5}, gravity=(0.0, 0.0, -9.81)),
        engine.evaluate(touches=[Touch(40, [0.0, 0.0, -1e-2])]),
        engine.evaluate(),
    ]
    return [frame.method for frame in frames], sorted(set(signatures().items()) - set(before.items()))


def test_hard_frames_compile_nothing(model_with_everything):
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        methods, late = pool.submit(hard_frames, model_with_everything).result()
    assert any("mended" in method for method in methods)
    assert any("went back" in method for method in methods)
    assert late == []
