import numpy as np
import pytest

import risorius
from risorius.errors import InputError


@pytest.fixture
def engine(synthetic_model):
    return risorius.Engine(synthetic_model)


def test_rest_is_the_rest_face(engine, synthetic_model):
    frame = engine.evaluate({})
    np.testing.assert_array_equal(frame.vertices, synthetic_model.rest_vertices)
    assert not frame.coordinates.any()


def test_vertices_are_rest_plus_basis_times_coordinates(engine, synthetic_model):
    frame = engine.evaluate({"AU12": 0.6, "jaw_open": 0.5, "jaw_sideways": -0.3})
    expected = synthetic_model.rest_vertices + np.tensordot(frame.coordinates, synthetic_model.basis, axes=1)
    np.testing.assert_allclose(frame.vertices, expected, atol=1e-8)
    assert frame.vertices.dtype == np.float32
    assert frame.converged
    assert frame.method == "polynomial"
    assert frame.elapsed > 0


def test_the_jaw_moves_exactly(engine, synthetic_model):
    frame = engine.evaluate({"jaw_open": 1.0, "jaw_forward": -0.5})
    exact = synthetic_model.poses.jaw.lift_coordinates((1.0, -0.5, 0.0))
    np.testing.assert_array_equal(frame.coordinates[:4], exact)


def test_array_and_names_agree(engine):
    weights = np.zeros(len(engine.inputs))
    weights[[engine.inputs.index("AU12_L"), engine.inputs.index("AU12_R")]] = 0.4
    np.testing.assert_array_equal(engine.evaluate(weights).vertices, engine.evaluate({"AU12": 0.4}).vertices)


def test_muscles_add_to_action_units(engine):
    both = engine.evaluate({"AU12_L": 0.3}, muscles={"zygomaticus_major_L": 0.3})
    np.testing.assert_allclose(both.coordinates, engine.evaluate({"AU12_L": 0.6}).coordinates, atol=1e-15)


def test_superposition_is_additive_and_the_learned_map_is_not(synthetic_model):
    linear = risorius.Engine(synthetic_model, scene=risorius.Scene(nonlinear=False))

    def gap(engine):
        both = engine.evaluate({"AU12": 1.0}).coordinates
        one_by_one = engine.evaluate({"AU12_L": 1.0}).coordinates + engine.evaluate({"AU12_R": 1.0}).coordinates
        return np.abs(both - one_by_one).max()

    assert linear.evaluate({}).method == "superposition"
    assert gap(linear) == 0.0
    assert gap(risorius.Engine(synthetic_model)) == pytest.approx(0.3)


def test_frame_is_written_into_the_callers_buffer(engine):
    buffer = np.full((len(engine.model.rest_vertices), 3), np.nan, dtype=np.float32)
    frame = engine.evaluate({"AU12": 1.0}, out=buffer)
    assert frame.vertices is buffer
    assert np.isfinite(buffer).all()


@pytest.mark.parametrize("shape", [(3, 3), (960,)])
def test_buffer_of_wrong_shape_is_refused(engine, shape):
    with pytest.raises(InputError, match=r"out: .* float32 array of shape \(320, 3\)"):
        engine.evaluate({"AU12": 1.0}, out=np.zeros(shape, dtype=np.float32))


def test_frames_do_not_share_memory(engine):
    first = engine.evaluate({"AU12": 1.0})
    kept = first.coordinates.copy(), first.vertices.copy()
    engine.evaluate({"AU12": 0.1})
    np.testing.assert_array_equal(first.coordinates, kept[0])
    np.testing.assert_array_equal(first.vertices, kept[1])
