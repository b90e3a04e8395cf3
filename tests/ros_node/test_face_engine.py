"""The node in a process of its own, driven from this one."""

from __future__ import annotations

import re
import signal
import subprocess
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import risorius
from risorius.carried_basis import CarriedBasis

pytest.importorskip("rclpy", reason="rclpy is not installed and no ROS 2 is sourced")

from rclpy.time import Time
from sensor_msgs.msg import JointState, PointCloud2
from tests.served_node import PATIENCE_S, RISORIUS, ServedNode, served, spin_until

from risorius_ros import environment, messages
from risorius_ros.client import FaceClient

pytestmark = pytest.mark.ros


@pytest.fixture(scope="module")
def node(model_file: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedNode]:
    with served(model_file, "--frame-id", "head", log=tmp_path_factory.mktemp("node") / "log") as started:
        yield started


def test_mesh_is_the_engine_s_in_the_frame_of_rep_103(node: ServedNode, synthetic_model: risorius.ReducedModel) -> None:
    with FaceClient(engine=node.name) as client:
        received = client.ask({"AU12": 1.0, "jaw_open": 0.3}, PATIENCE_S)
    left, up, out = risorius.Engine(synthetic_model).evaluate({"AU12": 1.0, "jaw_open": 0.3}).vertices.T
    np.testing.assert_allclose(received, np.column_stack([out, left, up]), atol=1e-6)


def test_mesh_carries_the_stamp_of_its_input_and_the_frame_of_the_parameter(node: ServedNode) -> None:
    received: list[PointCloud2] = []
    with FaceClient(engine=node.name) as client:
        client.node.create_subscription(PointCloud2, client.topic(messages.MESH), received.append, messages.STREAM)
        spin_until(client, lambda: client.send({"AU12": 0.5}) and received)
        stamp = client.send({"AU12": 0.25})
        spin_until(client, lambda: Time.from_msg(received[-1].header.stamp).nanoseconds == stamp)
    assert received[-1].header.frame_id == "head"


def test_inputs_that_a_message_does_not_name_go_to_zero(
    node: ServedNode, synthetic_model: risorius.ReducedModel
) -> None:
    with FaceClient(engine=node.name) as client:
        client.ask({"AU12": 1.0, "jaw_open": 1.0}, PATIENCE_S)
        received = client.ask({"AU12_L": 1.0}, PATIENCE_S)
    expected = risorius.Engine(synthetic_model).evaluate({"AU12_L": 1.0}).vertices
    np.testing.assert_allclose(messages.from_rep103(received), expected, atol=1e-6)


def test_topology_reaches_one_who_comes_late(node: ServedNode, synthetic_model: risorius.ReducedModel) -> None:
    with FaceClient(engine=node.name) as early:
        early.ask({}, PATIENCE_S)
    with FaceClient(engine=node.name) as late:
        spin_until(late, lambda: late.topology)
    assert late.topology is not None
    vertices, triangles = late.topology
    np.testing.assert_allclose(messages.from_rep103(vertices), synthetic_model.rest_vertices, atol=1e-7)
    np.testing.assert_array_equal(triangles, synthetic_model.triangles)


def test_a_scene_publishes_its_region_only(
    model_file: Path, synthetic_model: risorius.ReducedModel, tmp_path: Path
) -> None:
    scene = risorius.Scene(inputs=("AU12_L", "jaw_open"), region=tuple(range(100)))
    scene.save(tmp_path / "scene.yaml")
    with (
        served(model_file, "--scene", str(tmp_path / "scene.yaml"), log=tmp_path / "log") as node,
        FaceClient(engine=node.name) as client,
    ):
        received = client.ask({"AU12": 1.0, "jaw_open": 0.3}, PATIENCE_S)
        spin_until(client, lambda: client.topology)
    engine = risorius.Engine(synthetic_model, scene)
    expected = engine.evaluate({"AU12_L": 1.0, "jaw_open": 0.3}).vertices
    np.testing.assert_allclose(messages.from_rep103(received), expected, atol=1e-6)
    assert client.topology is not None
    np.testing.assert_array_equal(client.topology[1], engine.triangles)


def test_garbage_is_counted_and_the_next_good_message_answered(
    node: ServedNode, synthetic_model: risorius.ReducedModel
) -> None:
    with FaceClient(engine=node.name) as client:
        client.ask({}, PATIENCE_S)
        raw = client.node.create_publisher(JointState, client.topic(messages.ACTION_UNITS), messages.STREAM)
        spin_until(client, lambda: raw.get_subscription_count())
        for weights in (
            {"AU12": float("nan")},
            {"AU12": float("inf"), "jaw_open": float("-inf")},
            {"AU12": 1e300, "jaw_sideways": -7.0},
            {"no_such_muscle": 0.5, "": 1.0, "AU12 ": 1.0},
        ):
            assert np.isfinite(client.ask(weights, PATIENCE_S)).all()
        raw.publish(JointState(name=["AU12"], position=[]))
        raw.publish(JointState(position=[0.5]))
        received = client.ask({"AU12": 1.0}, PATIENCE_S)
    expected = risorius.Engine(synthetic_model).evaluate({"AU12": 1.0}).vertices
    np.testing.assert_allclose(messages.from_rep103(received), expected, atol=1e-6)
    assert node.process.poll() is None
    warnings = [line for line in node.output.splitlines() if "bad input" in line]
    assert len(warnings) == 1, "throttled to one in five seconds"


def test_warning_names_unknown_inputs_and_counts_mouths_that_went_back(
    walled_model: risorius.ReducedModel, tmp_path: Path
) -> None:
    walled_model.save(tmp_path / "model.h5")
    with served(tmp_path / "model.h5", log=tmp_path / "log") as node, FaceClient(engine=node.name) as client:
        client.ask({"frobnicator": 0.5, "jaw_open": 1.0}, PATIENCE_S)
        spin_until(client, lambda: "unknown 1, mouths that went back 1; unknown names: frobnicator" in node.output)


def test_every_weight_is_answered_at_once(node: ServedNode, capsys: pytest.CaptureFixture[str]) -> None:
    latencies: list[float] = []
    with FaceClient(lambda stamp, _: latencies.append(1e-6 * (time.time_ns() - stamp)), engine=node.name) as client:
        client.ask({}, PATIENCE_S)
        latencies.clear()
        for step in range(120):
            answered = len(latencies)
            client.send({"AU12": step / 120})
            spin_until(client, lambda answered=answered: len(latencies) > answered)
    with capsys.disabled():
        print(f"\nAU -> mesh, two processes: median {np.median(latencies):.2f} ms", end=" ")
    assert len(latencies) == 120


def test_meshes_over_the_default_segment_of_fast_dds_arrive(
    synthetic_model: risorius.ReducedModel, tmp_path: Path
) -> None:
    copies = 160  # 51 200 vertices: 600 KiB a mesh, the default segment has 512
    large = replace(
        synthetic_model,
        rest_vertices=np.tile(synthetic_model.rest_vertices, (copies, 1)),
        carried_basis=CarriedBasis.of_vertices(np.tile(synthetic_model.basis, (1, copies, 1))),
    )
    large.save(tmp_path / "large.h5")
    stamps = set()
    with (
        served(tmp_path / "large.h5", log=tmp_path / "log") as node,
        FaceClient(lambda stamp, _: stamps.add(stamp), engine=node.name) as client,
    ):
        client.ask({}, PATIENCE_S)
        sent = []
        for step in range(40):
            sent.append(client.send({"AU12": step / 40}))
            end = time.monotonic() + 0.05
            while sent[-1] not in stamps and time.monotonic() < end:
                client.spin_once(0.01)
    assert len(stamps & set(sent)) > 30


def test_a_slider_of_the_page_moves_the_published_mesh(
    model_file: Path, synthetic_model: risorius.ReducedModel, tmp_path: Path
) -> None:
    pytest.importorskip("meshcat", reason="the extra `view` is not installed")
    import asyncio
    import json

    from tornado.websocket import websocket_connect

    async def move_slider(page: str) -> None:
        socket = await websocket_connect(page.replace("http", "ws") + "face")
        await socket.write_message(json.dumps({"inputs": [["AU12", 0.75]]}))
        await asyncio.sleep(0)
        socket.close()

    with served(model_file, "--preview", log=tmp_path / "log") as node, FaceClient(engine=node.name) as client:
        client.ask({"jaw_open": 0.5}, PATIENCE_S)
        before = client.mesh
        page = re.search(r"http://127\.0\.0\.1:\d+/", node.output)
        assert page
        asyncio.run(move_slider(page[0]))
        spin_until(client, lambda: client.mesh is not before)
        assert client.mesh is not None
        expected = risorius.Engine(synthetic_model).evaluate({"AU12": 0.75, "jaw_open": 0.5}).vertices
        np.testing.assert_allclose(messages.from_rep103(client.mesh[1]), expected, atol=1e-6)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_stop_under_load_is_clean(model_file: Path, tmp_path: Path, number: signal.Signals) -> None:
    with served(model_file, "--preview", log=tmp_path / "log") as node, FaceClient(engine=node.name) as client:
        client.ask({}, PATIENCE_S)
        for step in range(200):
            client.send({"AU12": step / 200})
        assert node.stopped_by(number) == 0
    assert "Traceback" not in node.output


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["absent.h5"], "absent.h5: no such file"),
        (["README.md"], "README.md: not a readable HDF5 file"),
        (["MODEL", "--ros-args", "-r", "nonsense"], "ROS 2 did not start"),
        (["MODEL", "--ros-args", "-p", "frame_id:=5"], "parameter frame_id"),
        (["MODEL", "--preview", "--port", "70000"], "parameter preview_port"),
    ],
)
def test_what_it_cannot_start_with_gets_one_line_and_exit_2(
    model_file: Path, tmp_path: Path, options: list[str], said: str
) -> None:
    (tmp_path / "README.md").write_text("# no model\n")
    command = [RISORIUS, "serve", *(option.replace("MODEL", str(model_file)) for option in options)]
    ended = subprocess.run(
        command, cwd=tmp_path, env=environment.of_child(), capture_output=True, text=True, timeout=PATIENCE_S
    )
    own_lines = [line for line in ended.stderr.splitlines() if line.startswith("risorius: ")]
    assert ended.returncode == 2
    assert len(own_lines) == 1
    assert said in own_lines[0]
    assert "Traceback" not in ended.stderr


def test_an_unknown_option_is_refused(model_file: Path) -> None:
    command = [RISORIUS, "serve", model_file, "--prewiev"]
    ended = subprocess.run(command, env=environment.of_child(), capture_output=True, text=True, timeout=PATIENCE_S)
    assert ended.returncode == 2
    assert "--prewiev" in ended.stderr


def test_a_dense_stream_shows_inertia_and_a_lone_message_the_face_at_rest(
    lively_model: risorius.ReducedModel, tmp_path: Path
) -> None:
    lively_model.save(tmp_path / "model.h5")
    with served(tmp_path / "model.h5", log=tmp_path / "log") as node, FaceClient(engine=node.name) as client:
        client.ask({}, PATIENCE_S)
        time.sleep(0.2)
        alone = client.ask({"AU12": 1.0}, PATIENCE_S)
        time.sleep(0.2)
        client.ask({}, PATIENCE_S)
        stamp = client.send({"AU12": 1.0})
        spin_until(client, lambda: client.mesh and client.mesh[0] == stamp)
        moving = client.mesh[1]
    rest, still = lively_model.rest_vertices, risorius.Engine(lively_model).evaluate({"AU12": 1.0}).vertices
    np.testing.assert_allclose(messages.from_rep103(alone), still, atol=1e-6)
    share = np.abs(messages.from_rep103(moving) - rest).max() / np.abs(still - rest).max()
    assert share < 0.9
