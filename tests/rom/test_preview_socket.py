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
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the extra `view` is not installed")
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.websocket import WebSocketClientConnection, websocket_connect

from risorius import Engine, InputError, ReducedModel
from risorius.preview import Preview, server, sliders

PATIENCE = 60  # seconds before a test that waits for the other side gives up
EXPRESSION = {"AU12_L": 0.9, "AU12_R": 0.2, "jaw_open": 0.4, "jaw_sideways": -0.3}
RISORIUS = [sys.executable, "-c", "from risorius.cli import main; main()"]


class Stand:
    """A preview of the synthetic model, its engine and the slider moves that arrived."""

    def __init__(self, model: ReducedModel) -> None:
        self.engine = Engine(model)
        self.moves: list[tuple[str, float]] = []
        self.preview = Preview(self.engine, on_input=lambda name, value: self.moves.append((name, value)))
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


async def join(address: str) -> tuple[WebSocketClientConnection, dict[str, Any], np.ndarray]:
    """Connect as a page does; return the setup and the basis (r, n, 3) as well."""
    page = await connect(address, "/face", Origin=f"http://{address}")
    setup = json.loads(await page.read_message())
    basis = await page.read_message()
    assert struct.unpack("<II", basis[:8]) == (server.KIND_BASIS, 0)
    return page, setup, np.frombuffer(basis[8:], "<f4").reshape(setup["rank"], -1, 3)


async def read_frame(page: WebSocketClientConnection, rank: int) -> tuple[int, np.ndarray, dict[str, Any]]:
    """Return ticket, coordinates (r,) and status of the next frame message."""
    message = await page.read_message()
    kind, ticket = struct.unpack("<II", message[:8])
    assert kind == server.KIND_FRAME
    return ticket, np.frombuffer(message[8 : 8 + 4 * rank], "<f4"), json.loads(message[8 + 4 * rank :])


def test_basis_and_coordinates_give_the_vertices(stand: Stand) -> None:
    async def work() -> tuple[np.ndarray, np.ndarray]:
        page, setup, basis = await join(stand.address)
        _, coordinates, _ = await read_frame(page, setup["rank"])
        return basis, coordinates

    stand.show(**EXPRESSION)
    basis, coordinates = talk(work())
    vertices = stand.engine.model.rest_vertices + np.tensordot(coordinates, basis, 1)
    assert np.abs(vertices - stand.engine.evaluate(EXPRESSION).vertices).max() < 1e-7


def test_page_that_never_acknowledges_is_sent_two_frames_and_then_the_latest(stand: Stand) -> None:
    async def work() -> list[int]:
        page, setup, _ = await join(stand.address)
        first, _, status = await read_frame(page, setup["rank"])
        sequences = [status["sequence"]]
        for _ in range(5000):
            last = stand.show()
        second, _, status = await read_frame(page, setup["rank"])
        sequences.append(status["sequence"])
        await page.write_message(json.dumps({"drawn": second}))
        _, _, status = await read_frame(page, setup["rank"])
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
        page, setup, _ = await join(stand.address)
        await read_frame(page, setup["rank"])
        await page.write_message(message)
        assert await page.read_message() is None
        return page.close_code

    assert talk(work()) == 1008
    assert stand.moves == []


def test_busy_port_is_an_error_that_names_it(stand: Stand) -> None:
    with pytest.raises(InputError, match=rf"port {stand.port} .*choose another port"):
        Preview(stand.engine, port=stand.port, on_input=lambda *_: None)


@pytest.mark.parametrize("port", [0, -1, 65536])
def test_port_that_does_not_exist_is_refused(stand: Stand, port: int) -> None:
    with pytest.raises(InputError, match="1 to 65535"):
        Preview(stand.engine, port=port, on_input=lambda *_: None)


def test_unknown_host_is_refused(stand: Stand) -> None:
    with pytest.raises(InputError, match=r"host 'no\.such\.host\.invalid'"):
        Preview(stand.engine, host="no.such.host.invalid", on_input=lambda *_: None)


def test_frame_of_another_model_is_refused(stand: Stand) -> None:
    frame = stand.engine.evaluate()
    foreign = type(frame)(frame.vertices, np.zeros(3), 0.0, "polynomial", True, 0.0)
    with pytest.raises(InputError, match=r"\(10,\) expected"):
        stand.preview.show(foreign)


def test_listens_on_this_machine_only(stand: Stand) -> None:
    assert stand.preview.url.startswith("http://127.0.0.1:")
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.2", stand.port), timeout=PATIENCE)


def test_page_may_be_served_to_other_machines_when_asked(stand: Stand) -> None:
    with closing(Preview(stand.engine, host="0.0.0.0", on_input=lambda *_: None)) as preview:
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
        page, setup, _ = await join(stand.address)
        await read_frame(page, setup["rank"])
        await asyncio.to_thread(stand.preview.close)
        assert await page.read_message() is None
        return page.close_code

    assert talk(work()) == 1001
    stand.preview.close()
    stand.show()  # harmless: a frame may arrive while a node shuts down
    Preview(stand.engine, port=stand.port, on_input=lambda *_: None).close()


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
        page, setup, _ = await join(address)
        ticket, coordinates, _ = await read_frame(page, setup["rank"])
        await page.write_message(json.dumps({"inputs": [["jaw_open", 0.5], ["AU12_L", 0.25]]}))
        while not coordinates.any():
            await page.write_message(json.dumps({"drawn": ticket}))
            ticket, coordinates, _ = await read_frame(page, setup["rank"])
        return coordinates

    process = start_view(model_file)
    try:
        coordinates = talk(work(address_of(process)))
    finally:
        process.send_signal(signal.SIGINT)
        rest, _ = process.communicate(timeout=PATIENCE)
    expected = Engine(synthetic_model).evaluate({"jaw_open": 0.5, "AU12_L": 0.25}).coordinates
    assert np.abs(coordinates - expected).max() < 1e-6
    assert (process.returncode, rest.strip()) == (0, "stopped")


def test_view_command_plays_expressions_for_the_given_time(model_file: Path) -> None:
    async def work(address: str) -> int:
        page, setup, _ = await join(address)
        coordinates = np.zeros(setup["rank"])
        while not coordinates.any():
            ticket, coordinates, status = await read_frame(page, setup["rank"])
            await page.write_message(json.dumps({"drawn": ticket}))
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
