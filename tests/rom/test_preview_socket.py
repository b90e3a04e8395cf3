"""The live preview's server, spoken to by a bare websocket, and the command that runs it."""

from __future__ import annotations

import asyncio
import json
import signal
import socket
import struct
import subprocess
import sys
from collections.abc import Awaitable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the extra `view` is not installed")
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.websocket import WebSocketClientConnection, websocket_connect

from risorius import Engine, InputError, ReducedModel
from risorius.preview import Preview, sliders

PATIENCE = 60  # seconds before a test that waits for the other side gives up
EXPRESSION = {"AU12_L": 0.9, "AU12_R": 0.2, "jaw_open": 0.4, "jaw_sideways": -0.3}
RISORIUS = [sys.executable, "-c", "from risorius.cli import main; main()"]


class Stand:
    """A preview of the synthetic model, its engine and the slider moves that arrived."""

    def __init__(self, model: ReducedModel) -> None:
        self.engine = Engine(model)
        self.moves: list[tuple[str, float]] = []
        self.preview = Preview(self.engine.model, on_input=lambda name, value: self.moves.append((name, value)))
        self.address = self.preview.url.removeprefix("http://").rstrip("/")
        self.port = int(self.address.rpartition(":")[2])

    def show(self, **weights: float) -> int:
        return self.preview.show(self.engine.evaluate(weights))


@pytest.fixture
def stand(synthetic_model: ReducedModel) -> Iterator[Stand]:
    stand = Stand(synthetic_model)
    with closing(stand.preview):
        yield stand


def talk(work: Awaitable[Any]) -> Any:
    return asyncio.run(asyncio.wait_for(work, PATIENCE))  # type: ignore[arg-type]


async def connect(address: str, path: str, **headers: str) -> WebSocketClientConnection:
    return await websocket_connect(HTTPRequest(f"ws://{address}{path}", headers=headers))


async def join(address: str) -> tuple[WebSocketClientConnection, dict[str, Any]]:
    """Connect as a page does; return the setup as well."""
    page = await connect(address, "/face", Origin=f"http://{address}")
    return page, json.loads(await page.read_message())


async def read_frame(
    page: WebSocketClientConnection, setup: dict[str, Any]
) -> tuple[int, np.ndarray, np.ndarray, dict[str, Any]]:
    """Return ticket, lift coordinates, vertices (n, 3) and status of the next frame message."""
    message = await page.read_message()
    (ticket,) = struct.unpack("<I", message[:4])
    lifts = np.frombuffer(message, "<f4", setup["lifts"], 4)
    start = 4 + lifts.nbytes
    vertices = np.frombuffer(message, "<f4", 3 * setup["vertices"], start).reshape(-1, 3)
    return ticket, lifts, vertices, json.loads(message[start + vertices.nbytes :])


def test_page_is_sent_the_vertices_and_what_moves_companions(stand: Stand) -> None:
    async def work() -> tuple[np.ndarray, np.ndarray]:
        page, setup = await join(stand.address)
        _, lifts, vertices, _ = await read_frame(page, setup)
        return lifts, vertices

    stand.show(**EXPRESSION)
    lifts, vertices = talk(work())
    expected = stand.engine.evaluate(EXPRESSION)
    np.testing.assert_array_equal(vertices, expected.vertices)
    np.testing.assert_array_equal(lifts, expected.coordinates[: len(lifts)].astype(np.float32))
    assert len(lifts) == stand.engine.model.lifts > 0


def test_page_shows_the_face_at_rest_before_the_first_frame(stand: Stand) -> None:
    async def work() -> np.ndarray:
        page, setup = await join(stand.address)
        return (await read_frame(page, setup))[2]

    np.testing.assert_array_equal(talk(work()), stand.engine.model.rest_vertices)


def test_page_that_never_acknowledges_is_sent_two_frames_and_then_the_latest(stand: Stand) -> None:
    async def work() -> list[int]:
        page, setup = await join(stand.address)
        first, *_, status = await read_frame(page, setup)
        sequences = [status["sequence"]]
        for _ in range(5000):
            last = stand.show()
        second, *_, status = await read_frame(page, setup)
        sequences.append(status["sequence"])
        await page.write_message(json.dumps({"drawn": second}))
        *_, status = await read_frame(page, setup)
        assert status["sequence"] == last
        return [first, second, *sequences]

    first, second, *sequences = talk(work())
    assert (first, second) == (1, 2)
    assert sequences[0] == 0 < sequences[1]
    assert stand.preview.shown() == sequences[1]


@pytest.mark.parametrize("path", ["/face", "/meshcat"])
@pytest.mark.parametrize("origin", ["http://elsewhere.example", "http://127.0.0.1:1", "null"])
def test_pages_from_elsewhere_may_not_open_a_socket(stand: Stand, path: str, origin: str) -> None:
    with pytest.raises(HTTPClientError, match="403"):
        talk(connect(stand.address, path, Origin=origin))


@pytest.mark.parametrize("path", ["/face", "/meshcat"])
def test_own_page_may_open_a_socket(stand: Stand, path: str) -> None:
    talk(connect(stand.address, path, Origin=f"http://{stand.address}"))


def test_another_name_for_this_machine_is_not_served(stand: Stand) -> None:
    """A page elsewhere whose name is made to point here has the same origin by name, but not by address."""
    name = "elsewhere.example:" + stand.address.rpartition(":")[2]
    with pytest.raises(HTTPClientError, match="404"):
        talk(connect(stand.address, "/face", Host=name, Origin=f"http://{name}"))


@pytest.mark.parametrize(
    "message",
    [
        "no JSON",
        "[]",
        "[" * 60_000,
        '{"drawn": 999}',
        '{"drawn": [1]}',
        '{"inputs": []}',
        '{"inputs": [["AU99", 0.5]]}',
        '{"inputs": [["AU12", 1.5]]}',
        '{"inputs": [["AU12", NaN]]}',
        '{"inputs": [["AU12", "1"]]}',
        '{"inputs": [["AU12", 0.5], ["jaw_open", -0.5]]}',
        '{"inputs": [[["AU12"], 0.5]]}',
    ],
)
def test_message_that_no_page_sends_ends_the_connection(stand: Stand, message: str) -> None:
    async def work() -> int | None:
        page, setup = await join(stand.address)
        await read_frame(page, setup)
        await page.write_message(message)
        assert await page.read_message() is None
        return page.close_code

    assert talk(work()) == 1008
    assert stand.moves == []


def test_busy_port_is_an_error_that_names_it(stand: Stand) -> None:
    with pytest.raises(InputError, match=rf"port {stand.port} .*choose another port"):
        Preview(stand.engine.model, port=stand.port, on_input=lambda *_: None)


@pytest.mark.parametrize("port", [0, -1, 65536])
def test_port_that_does_not_exist_is_refused(stand: Stand, port: int) -> None:
    with pytest.raises(InputError, match="1 to 65535"):
        Preview(stand.engine.model, port=port, on_input=lambda *_: None)


def test_unknown_host_is_refused(stand: Stand) -> None:
    with pytest.raises(InputError, match=r"host 'no\.such\.host\.invalid'"):
        Preview(stand.engine.model, host="no.such.host.invalid", on_input=lambda *_: None)


def test_frame_of_another_model_is_refused(stand: Stand) -> None:
    frame = stand.engine.evaluate()
    foreign = replace(frame, vertices=frame.vertices[:3])
    with pytest.raises(InputError, match=r"vertices \(3, 3\), \(\d+, 3\) expected"):
        stand.preview.show(foreign)


def test_listens_on_this_machine_only(stand: Stand) -> None:
    assert stand.preview.url.startswith("http://127.0.0.1:")
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.2", stand.port), timeout=PATIENCE)


def test_page_may_be_served_to_other_machines_when_asked(stand: Stand) -> None:
    with closing(Preview(stand.engine.model, host="0.0.0.0", on_input=lambda *_: None)) as preview:
        name, _, port = preview.url.removeprefix("http://").rstrip("/").partition(":")
        assert name == "localhost"
        other_name = f"robot.example:{port}"
        page = talk(connect(f"127.0.0.1:{port}", "/face", Host=other_name, Origin=f"http://{other_name}"))
        assert page is not None
        with pytest.raises(HTTPClientError, match="403"):
            talk(connect(f"127.0.0.1:{port}", "/face", Host=other_name, Origin="http://elsewhere.example"))


def test_missing_package_names_the_extra() -> None:
    program = "import sys; sys.modules['meshcat'] = None; import risorius.preview"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=PATIENCE)
    assert "MissingExtraError: the live preview needs the Python package 'meshcat'" in done.stderr
    assert "risorius[view]" in done.stderr


def test_close_frees_the_port_ends_connections_and_may_be_repeated(synthetic_model: ReducedModel) -> None:
    stand = Stand(synthetic_model)

    async def work() -> int | None:
        page, setup = await join(stand.address)
        await read_frame(page, setup)
        await asyncio.to_thread(stand.preview.close)
        assert await page.read_message() is None
        return page.close_code

    assert talk(work()) == 1001
    stand.preview.close()
    stand.show()  # harmless: a frame may arrive while a node shuts down
    Preview(stand.engine.model, port=stand.port, on_input=lambda *_: None).close()


def test_sliders_pair_sides_and_keep_ranges(synthetic_model: ReducedModel) -> None:
    table = {slider.name: slider for slider in sliders.sliders_of(synthetic_model.inputs)}
    assert list(table) == ["AU12", "AU26", "AU27", "jaw_open", "jaw_forward", "jaw_sideways"]
    assert table["AU12"].inputs == ("AU12_L", "AU12_R")
    assert (table["AU12"].label, table["AU12"].group) == ("Lip Corner Puller", "Lower face")
    assert [table[name].lower for name in ("AU12", "jaw_open", "jaw_forward", "jaw_sideways")] == [0, 0, -1, -1]
    assert {table[name].group for name in ("AU26", "AU27", "jaw_open")} == {"Jaw"}


@pytest.fixture
def model_file(synthetic_model: ReducedModel, tmp_path: Path) -> Path:
    path = tmp_path / "model.h5"
    synthetic_model.save(path)
    return path


def test_view_command_moves_the_face_by_sliders_until_interrupted(
    model_file: Path, synthetic_model: ReducedModel
) -> None:
    async def work(address: str) -> np.ndarray:
        page, setup = await join(address)
        ticket, _, rest, _ = await read_frame(page, setup)
        vertices = rest
        await page.write_message(json.dumps({"inputs": [["jaw_open", 0.5], ["AU12_L", 0.25]]}))
        while np.array_equal(vertices, rest):
            await page.write_message(json.dumps({"drawn": ticket}))
            ticket, _, vertices, _ = await read_frame(page, setup)
        return vertices

    process = start_view(model_file)
    try:
        vertices = talk(work(address_of(process)))
    finally:
        process.send_signal(signal.SIGINT)
        rest, _ = process.communicate(timeout=PATIENCE)
    expected = Engine(synthetic_model).evaluate({"jaw_open": 0.5, "AU12_L": 0.25}).vertices
    np.testing.assert_array_equal(vertices, expected)
    assert (process.returncode, rest.strip()) == (0, "stopped")


def test_view_command_plays_expressions_for_the_given_time(model_file: Path) -> None:
    async def work(address: str) -> int:
        page, setup = await join(address)
        ticket, _, first, status = await read_frame(page, setup)
        vertices = first
        while np.array_equal(vertices, first):
            await page.write_message(json.dumps({"drawn": ticket}))
            ticket, _, vertices, status = await read_frame(page, setup)
        return status["sequence"]

    process = start_view(model_file, "--play", "--seconds", "2")
    try:
        assert talk(work(address_of(process))) > 1
    finally:
        process.communicate(timeout=PATIENCE)
    assert process.returncode == 0


def test_view_command_tells_a_busy_port_in_one_line(model_file: Path, stand: Stand) -> None:
    done = subprocess.run(
        [*RISORIUS, "view", str(model_file), "--port", str(stand.port)],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert f"port {stand.port}" in done.stderr


def start_view(model_file: Path, *options: str) -> subprocess.Popen[str]:
    return subprocess.Popen([*RISORIUS, "view", str(model_file), *options], stdout=subprocess.PIPE, text=True)


def address_of(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline().partition("http://")[2].partition("/")[0]
