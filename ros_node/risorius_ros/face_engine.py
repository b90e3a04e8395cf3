"""The node `face_engine`: every message of weights is answered at once with the deformed face."""

from __future__ import annotations

import signal
import threading
import time
from collections import Counter, deque
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import rclpy
from builtin_interfaces.msg import Time
from rcl_interfaces.msg import IntegerRange, ParameterDescriptor
from rclpy.exceptions import ParameterException
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState, PointCloud2
from shape_msgs.msg import Mesh

import risorius
from risorius.stream import InputGate
from risorius_ros import messages

if TYPE_CHECKING:
    from risorius.preview import Preview

_WARNING_PERIOD_S = 5.0
_STOP_POLL_S = 0.2
_NAMES_SHOWN = 8
_LONGEST_STEP_S = 0.1


class FaceEngine(Node):
    """Subscribes to action units and publishes the mesh; everything but `_on_slider` runs in the executor's thread.

    Raises risorius.InputError when a parameter or the model it names is unusable.
    """

    def __init__(self) -> None:
        super().__init__(messages.NODE_NAME)
        path = self._parameter("model_path", "", "Reduced model to evaluate (HDF5), from `risorius train`.")
        scene_path = self._parameter("scene_path", "", "Scene to show (YAML); everything the model can without one.")
        frame_id = self._parameter("frame_id", "face", "Frame of the vertices: x out of the face, y left, z up.")
        with_preview = self._parameter("preview", False, "Serve a page that shows the face and has sliders.")
        port = self._parameter(
            "preview_port",
            0,
            "Port of that page on 127.0.0.1; 0 takes a free one.",
            integer_range=[IntegerRange(from_value=0, to_value=65535, step=1)],
        )
        if not path:
            raise risorius.InputError("parameter model_path is empty; set it to a model file of `risorius train`")
        scene = risorius.Scene.load(scene_path) if scene_path else risorius.Scene()
        self._engine = risorius.Engine(messages.rotated_to_rep103(risorius.load(path)), scene)
        rest = self._engine.model
        self._gate = InputGate(rest.inputs)
        self._weights = np.zeros(len(rest.inputs.names))
        self._mesh = messages.mesh_message(len(rest.rest_vertices), frame_id)
        self._stamp = Time()
        self._vertices = messages.vertices_of(self._mesh)
        self._given_up: Counter[str] = Counter()
        self._warned_of = 0
        self._warned_at = -_WARNING_PERIOD_S

        self._slider_moves: deque[tuple[str, float]] = deque()
        self._slider_moved = self.create_guard_condition(self._answer_sliders)
        self._preview = self._open_preview(port or None) if with_preview else None

        self._topology_publisher = self.create_publisher(Mesh, messages.TOPOLOGY, messages.LATCHED)
        self._topology_publisher.publish(messages.topology_message(rest.rest_vertices, rest.triangles))
        self._mesh_publisher = self.create_publisher(PointCloud2, messages.MESH, messages.STREAM)
        self.create_subscription(JointState, messages.ACTION_UNITS, self._answer, messages.STREAM)
        self.get_logger().info(f"{path}: {len(rest.rest_vertices)} vertices, inputs {', '.join(rest.inputs.names)}")
        if self._preview:
            self.get_logger().info(f"page: {self._preview.url}")

    def close(self) -> None:
        """Close the page and the topics."""
        if self._preview:
            self._preview.close()
        self.destroy_node()

    def _parameter(self, name: str, default: Any, description: str, **constraint: Any) -> Any:
        descriptor = ParameterDescriptor(description=description, read_only=True, **constraint)
        try:
            return self.declare_parameter(name, default, descriptor).value
        except ParameterException as error:
            raise risorius.InputError(f"parameter {name}: {error}") from error

    def _open_preview(self, port: int | None) -> Preview:
        from risorius.preview import Preview

        return Preview(messages.rotated_from_rep103(self._engine.model), port=port, on_input=self._on_slider)

    def _answer(self, message: JointState) -> None:
        weights = self._gate.message(message.name, message.position)
        if weights is not None:
            self._weights = weights
            self._publish(message.header.stamp, self._step(message.header.stamp))
        self._warn_of_bad_input()

    def _on_slider(self, name: str, value: float) -> None:
        """Hand a slider's value to the executor's thread; runs in the page server's thread."""
        self._slider_moves.append((name, value))
        self._slider_moved.trigger()

    def _answer_sliders(self) -> None:
        while self._slider_moves:
            self._weights = self._gate.weights([self._slider_moves.popleft()], self._weights)
        self._publish(self.get_clock().now().to_msg())
        self._warn_of_bad_input()

    def _step(self, stamp: Time) -> float | None:
        """Seconds since the message before, of a stream with stamps; None where there is none that is dense enough."""
        before, self._stamp = self._stamp, stamp
        step = stamp.sec - before.sec + 1e-9 * (stamp.nanosec - before.nanosec)
        return step if "inertia" in self._engine.effects and 0.0 < step <= _LONGEST_STEP_S else None

    def _publish(self, stamp: Time, step: float | None = None) -> None:
        frame = self._engine.evaluate(self._weights, step=step, out=self._vertices)
        self._given_up["frames held"] += not frame.converged
        self._given_up["mouths that went back"] += "went back" in frame.method
        self._mesh.header.stamp = stamp
        self._mesh_publisher.publish(self._mesh)
        if self._preview:
            self._preview.show(replace(frame, vertices=messages.from_rep103(frame.vertices)))

    def _warn_of_bad_input(self) -> None:
        counts = self._gate.counts + self._given_up
        total = counts.total()
        now = time.monotonic()
        if total == self._warned_of or now - self._warned_at < _WARNING_PERIOD_S:
            return
        self._warned_of, self._warned_at = total, now
        text = ", ".join(f"{kind} {count}" for kind, count in counts.items())
        if self._gate.unknown_names:
            text += f"; unknown names: {', '.join(sorted(self._gate.unknown_names)[:_NAMES_SHOWN])}"
            self._gate.unknown_names.clear()
        self.get_logger().warning(f"bad input since the start: {text}")


def run(arguments: Sequence[str]) -> None:
    """Run the node until SIGINT or SIGTERM. Raises risorius.InputError for arguments it cannot start with."""
    stopped = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopped.set())
    try:
        # rclpy's own handlers would pull the context away from under a callback that is about to publish.
        rclpy.init(args=list(arguments), signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:
        raise risorius.InputError(f"ROS 2 did not start: {error}") from error
    try:
        node = FaceEngine()
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        while not stopped.is_set():
            executor.spin_once(timeout_sec=_STOP_POLL_S)
        executor.shutdown()
        node.close()
    finally:
        rclpy.try_shutdown()
