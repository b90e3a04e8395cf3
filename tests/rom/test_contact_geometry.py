import h5py
import numpy as np
import pytest

from risorius.companion import JAW, SKULL
from risorius.contact_geometry import ContactGeometry, Obstacle
from risorius.errors import InputError


def test_a_file_gives_back_what_skin_can_touch():
    distances = np.arange(24, dtype=np.float32).reshape(2, 3, 4)
    teeth = Obstacle(np.array([0.1, 0.2, 0.3]), 1e-3, distances, JAW)
    geometry = ContactGeometry({"teeth_lower": teeth}, np.array([[3, 5], [4, 6]]))
    with h5py.File("geometry", "w", driver="core", backing_store=False) as memory:
        geometry.write(memory.create_group("contact"))
        read = ContactGeometry.read(memory["contact"])
    found = read.obstacles["teeth_lower"]
    assert (found.spacing, found.moves_with) == (1e-3, JAW)
    np.testing.assert_array_equal(found.distances, distances)
    np.testing.assert_array_equal(found.origin, teeth.origin)
    np.testing.assert_array_equal(read.seam, geometry.seam)


def test_an_obstacle_goes_with_skull_or_jaw():
    distances = np.zeros((2, 2, 2), np.float32)
    assert Obstacle(np.zeros(3), 1e-3, distances).moves_with == SKULL
    with pytest.raises(InputError, match="moves_with 'hair'"):
        Obstacle(np.zeros(3), 1e-3, distances, "hair")
