"""A Python client of the node: send weights, receive meshes."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from types import TracebackType

import numpy as np
import numpy.typing as npt
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.time import Time
from sensor_msgs.msg import JointState, PointCloud2
from shape_msgs.msg import Mesh

from risorius import Error
from risorius_ros import messages
from risorius_ros.messages import FloatVectors

_RESEND_S = 0.1


class FaceClient:
    """Sends weights to a running `face_engine` and receives its meshes, in a ROS context of its own.

    node: the ROS node. topology: rest vertices (n, 3) and triangles (m, 3) of the engine, None until they arrived.
    mesh: stamp in nanoseconds and vertices (n, 3) of the last mesh, None before the first. Vertices are float32,
    metres, in the frame of REP-103. on_mesh: called by `spin_once` with stamp and vertices of each mesh.
    """

    def __init__(
        self,
        on_mesh: Callable[[int, FloatVectors], None] | None = None,
        *,
        engine: str = f"/{messages.NODE_NAME}",
    ) -> None:
        self.topology: tuple[FloatVectors, npt.NDArray[np.int32]] | None = None
        self.mesh: tuple[int, FloatVectors] | None = None
        self._on_mesh = on_mesh
        self._engine = engine
        self._last_stamp = 0
        self._context = rclpy.Context()
        self._context.init()
        self.node = rclpy.create_node("face_client", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._weights = self.node.create_publisher(JointState, self.topic(messages.ACTION_UNITS), messages.STREAM)
        self.node.create_subscription(PointCloud2, self.topic(messages.MESH), self._receive_mesh, messages.STREAM)
        self.node.create_subscription(Mesh, self.topic(messages.TOPOLOGY), self._receive_topology, messages.LATCHED)

    def __enter__(self) -> FaceClient:
        """Return the client itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Leave the ROS graph."""
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()

    def topic(self, private_name: str) -> str:
        """Full name of one of the engine's topics: `~/mesh` -> `/face_engine/mesh`."""
        return private_name.replace("~", self._engine)

    def send(self, weights: Mapping[str, float]) -> int:
        """Publish weights by name; inputs that are not named go to zero. Returns the stamp, nanoseconds."""
        self._last_stamp = max(self._last_stamp + 1, time.time_ns())
        message = JointState(name=list(weights), position=[float(weight) for weight in weights.values()])
        message.header.stamp = Time(nanoseconds=self._last_stamp).to_msg()
        self._weights.publish(message)
        return self._last_stamp

    def spin_once(self, timeout: float) -> None:
        """Wait for a message up to `timeout` seconds and handle it."""
        self._executor.spin_once(timeout_sec=timeout)

    def ask(self, weights: Mapping[str, float], timeout: float = 10.0) -> FloatVectors:
        """Send weights, again and again until the engine has been found, and return the mesh that answers them.

        Raises risorius.Error when none does within `timeout` seconds.
        """
        deadline = time.monotonic() + timeout
        while time.monotonic() < deadline:
            stamp = self.send(weights)
            resend_at = time.monotonic() + _RESEND_S
            while time.monotonic() < resend_at:
                self.spin_once(0.05)
                if self.mesh and self.mesh[0] == stamp:
                    return self.mesh[1]
        raise Error(f"{self._engine} did not answer within {timeout:g} s; start it with `risorius serve MODEL`")

    def _receive_mesh(self, message: PointCloud2) -> None:
        stamp = Time.from_msg(message.header.stamp).nanoseconds
        self.mesh = stamp, messages.vertices_of(message)
        if self._on_mesh:
            self._on_mesh(*self.mesh)

    def _receive_topology(self, message: Mesh) -> None:
        self.topology = messages.arrays_of(message)
