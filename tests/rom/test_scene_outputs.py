import numpy as np
import pytest

from risorius import Engine, InputError, Scene
from risorius.normals import vertex_normals
from risorius.strain import SurfaceStrain

TRIANGLES = np.array([[0, 1, 2], [1, 3, 2]], np.int32)
REST = np.array([[0, 0, 0], [0.02, 0.003, 0], [0.004, 0.03, 0], [0.03, 0.03, 0]], np.float32)
TURN = np.linalg.qr(np.array([[2.0, 1.0, 0.0], [-1.0, 2.0, 1.0], [0.5, 0.0, 1.0]]))[0]


def strains_under(deformation):
    return SurfaceStrain(REST, TRIANGLES).of((REST @ deformation.T).astype(np.float32))


def test_a_turned_surface_is_not_strained():
    np.testing.assert_allclose(strains_under(TURN), 0.0, atol=1e-6)


@pytest.mark.parametrize("deformation", [np.diag([1.3, 0.8, 2.0]), np.array([[1.0, 0.4, 0], [0, 1, 0], [0, 0, 1]])])
def test_strain_is_that_of_the_deformation_in_the_plane(deformation):
    plane = deformation[:, :2]
    exact = 0.5 * (np.linalg.eigvalsh(plane.T @ plane)[::-1] - 1.0)
    np.testing.assert_allclose(strains_under(TURN @ deformation), [exact, exact], atol=2e-6)


def test_a_triangle_without_area_is_refused():
    with pytest.raises(InputError, match="triangle 1 has no area at rest"):
        SurfaceStrain(REST, np.array([[0, 1, 2], [1, 1, 2]], np.int32))


def test_frames_hold_what_the_scene_wants_and_nothing_else(synthetic_model):
    plain = Engine(synthetic_model).evaluate({"AU12": 0.5})
    assert (plain.normals, plain.strain, plain.effort) == (None, None, None)
    engine = Engine(synthetic_model, Scene(outputs=("normals", "strain"), region=tuple(range(64))))
    frame = engine.evaluate({"AU12": 0.5})
    np.testing.assert_array_equal(frame.normals, vertex_normals(frame.vertices, engine.triangles))
    assert frame.strain.shape == (len(engine.triangles), 2)
    assert (frame.strain[:, 0] >= frame.strain[:, 1]).all()
    assert np.abs(engine.evaluate().strain).max() < 1e-5


def test_effort_needs_muscles_as_physics(synthetic_model):
    with pytest.raises(InputError, match="scene: outputs: effort: model 'synthetic' has no muscles as physics"):
        Engine(synthetic_model, Scene(outputs=("effort",)))
