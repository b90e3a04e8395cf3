"""Arrays in and out of messages, and the frame of REP-103."""

from __future__ import annotations

import numpy as np
import pytest

import risorius

pytest.importorskip("rclpy", reason="rclpy is not installed and no ROS 2 is sourced")

from risorius_ros import messages

pytestmark = pytest.mark.ros


def test_vertices_are_written_into_the_message_in_place() -> None:
    message = messages.mesh_message(3, "face")
    messages.vertices_of(message)[1] = (1.0, 2.0, 3.0)
    np.testing.assert_array_equal(np.frombuffer(bytes(message.data), np.float32)[3:6], [1.0, 2.0, 3.0])
    assert [(field.name, field.offset) for field in message.fields] == [("x", 0), ("y", 4), ("z", 8)]
    assert message.width * message.point_step == message.row_step == len(message.data)


def test_the_frame_of_rep_103_looks_along_x_and_keeps_triangles_turned_outwards(
    synthetic_model: risorius.ReducedModel,
) -> None:
    model = messages.rotated_to_rep103(synthetic_model)
    left, up, out = synthetic_model.rest_vertices.T
    np.testing.assert_array_equal(model.rest_vertices, np.column_stack([out, left, up]))
    a, b, c = (model.rest_vertices[corner] for corner in model.triangles.T)
    a0, b0, c0 = (synthetic_model.rest_vertices[corner] for corner in model.triangles.T)
    np.testing.assert_allclose(
        np.cross(b - a, c - a)[:, 0], np.cross(b0 - a0, c0 - a0)[:, 2], rtol=1e-5, err_msg="outward component"
    )
    np.testing.assert_array_equal(messages.from_rep103(model.rest_vertices), synthetic_model.rest_vertices)


def test_topology_survives_the_message(synthetic_model: risorius.ReducedModel) -> None:
    message = messages.topology_message(synthetic_model.rest_vertices, synthetic_model.triangles)
    vertices, triangles = messages.arrays_of(message)
    np.testing.assert_array_equal(vertices, synthetic_model.rest_vertices)
    np.testing.assert_array_equal(triangles, synthetic_model.triangles)
