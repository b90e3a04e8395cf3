import numpy as np
import pytest

from risorius.errors import InputError
from risorius_offline.discretisation import CellBlock, Discretisation, IntegratedBlock
from risorius_offline.elements import ELEMENTS
from tests.offline.meshes import box

TYPES = sorted(ELEMENTS)


@pytest.mark.parametrize("cell_type", TYPES)
def test_shape_functions_are_one_at_their_node_and_sum_to_one(cell_type):
    element = ELEMENTS[cell_type]
    nodes = np.array(element.nodes, dtype=float).T
    np.testing.assert_allclose(element.shape_functions(nodes), np.eye(len(element.nodes)), atol=1e-14)
    np.testing.assert_allclose(element.shape_functions(element.points).sum(axis=1), 1.0, atol=1e-14)


@pytest.mark.parametrize("cell_type", TYPES)
def test_gradients_reproduce_a_linear_field_and_weights_the_volume(cell_type):
    points, cells = box(cell_type, distortion=0.25)
    block = IntegratedBlock.of(points, cells)
    gradient = np.array([[0.3, -0.1, 0.2], [0.0, 0.5, 0.1], [-0.4, 0.2, 0.7]])
    found = np.einsum("eai,eqaj->eqij", (points @ gradient.T)[cells.connectivity], block.gradients)
    np.testing.assert_allclose(found, np.broadcast_to(gradient, found.shape), atol=1e-12)
    assert block.weights.sum() == pytest.approx(0.02**3, rel=1e-12)


@pytest.mark.parametrize("cell_type", TYPES)
def test_faces_point_outwards(cell_type):
    element = ELEMENTS[cell_type]
    nodes = np.array(element.nodes, dtype=float)
    middle = nodes[: element.corners].mean(axis=0)
    for face in element.faces:
        a, b, c = nodes[list(face[:3])]
        assert np.cross(b - a, c - a) @ (a - middle) > 0


def test_inverted_cell_is_refused_and_named():
    points, cells = box("hexahedron")
    wrong = cells.connectivity.copy()
    wrong[3] = wrong[3, [4, 5, 6, 7, 0, 1, 2, 3]]
    with pytest.raises(InputError, match=r"1 hexahedron cell\(s\) are inverted.*first cell 3.*VTK order"):
        Discretisation(points, [CellBlock("hexahedron", wrong, cells.layer)])


@pytest.mark.parametrize("cell_type", TYPES)
def test_nodal_volumes_sum_to_the_volume(cell_type):
    points, cells = box(cell_type, distortion=0.2)
    volumes = Discretisation(points, [cells]).nodal_volumes
    assert (volumes > 0).all()
    assert volumes.sum() == pytest.approx(0.02**3, rel=1e-12)


def test_a_node_of_no_cell_has_no_entries_in_the_pattern():
    points, cells = box("hexahedron", (1, 1, 1))
    apart = np.concatenate([points[:1], points])
    moved = CellBlock("hexahedron", cells.connectivity + 1, cells.layer)
    pattern, alone = (Discretisation(x, [c]).pattern for x, c in ((apart, moved), (points, cells)))
    assert (pattern[:3].nnz, pattern.nnz) == (0, alone.nnz)
    np.testing.assert_array_equal(pattern.indices, alone.indices + 3)
