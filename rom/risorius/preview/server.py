"""A web server with meshcat's viewer and a second socket that carries vertices and slider values.

Two websockets stand behind one page. `/meshcat` speaks meshcat's own protocol and sends the scene once. `/face` sends
the vertices of each frame as the engine wrote them, whatever effects had a part in them. Each page says what it has
drawn and is sent nothing more while two messages are on their way to it, and then the newest: a slow, hidden or hung
page costs neither memory nor time. Text messages are JSON; a frame is binary, little-endian:

    uint32 ticket, lift coordinates (lifts,) float32, vertices (n, 3) float32, then JSON: sequence number, status,
    moved sliders

A page answers {"drawn": ticket}, or {"inputs": [[name, value], ...]} when a slider moves.
"""

from __future__ import annotations

import asyncio
import json
import math
import socket
import struct
import threading
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import meshcat
import numpy as np
import numpy.typing as npt
from tornado.httpserver import HTTPServer
from tornado.netutil import bind_sockets
from tornado.web import Application, StaticFileHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from risorius.engine import Frame
from risorius.errors import InputError
from risorius.inputs import InputTable
from risorius.model import ReducedModel
from risorius.preview.sliders import sliders_of
from risorius.preview.stage import stage_commands

MAX_IN_FLIGHT = 2
_TICKET = struct.Struct("<I")
_PAGE = Path(__file__).parent / "page"
_LOOPBACK = {"127.0.0.1", "::1", "localhost"}
_ANY_ADDRESS = {"", "0.0.0.0", "::"}
_MAX_MESSAGE = 64 * 1024  # bytes from a page; all sliders at once take some 2 kB
_POLICY_VIOLATION, _GOING_AWAY = 1008, 1001  # websocket close codes


@dataclass(frozen=True)
class _Shown:
    """A frame as it goes over the wire."""

    sequence: int
    motion: bytes
    status: dict[str, Any]


class Preview:
    """Serves the page and shows frames on it. All methods may be called from any thread.

    on_input(name, value) is called in the server's thread when a slider moves; names are those of model.inputs or, for
    both sides at once, without `_L` and `_R`; values are finite and in range. It should hand over and return, and not
    call `close`. model: that of the engine whose frames are shown.

    host: address to listen on; the default lets in this machine only. port: None takes a free one.
    Raises InputError when the address cannot be listened on.
    """

    def __init__(
        self,
        model: ReducedModel,
        *,
        host: str = "127.0.0.1",
        port: int | None = None,
        on_input: Callable[[str, float], None],
    ) -> None:
        """Listen and start the server's thread."""
        self._table = model.inputs
        self._on_input = on_input
        self._stage = stage_commands(model)
        self._companions = {
            # column by column, as three.js has matrices
            name: companion.unit_transforms(model.poses).transpose(0, 2, 1).reshape(-1, 16).tolist()
            for name, companion in model.companions.items()
        }
        self._title = model.name
        self._lifts, self._shape = model.lifts, model.rest_vertices.shape
        self._values = np.zeros(len(self._table.names))
        self._faces: set[_FaceSocket] = set()
        self._newest_drawn = 0
        self._lock = threading.Lock()  # guards the four below
        self._sequence = 0
        self._latest = _Shown(0, _motion(np.zeros(model.lifts), model.rest_vertices), {})
        self._flush_is_due = False
        self._closed = False

        sockets = _listen(host, port)
        self.url = _url(host, sockets[0].getsockname()[1])
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name="risorius-preview", daemon=True)
        self._thread.start()
        self._server: HTTPServer = asyncio.run_coroutine_threadsafe(self._serve(sockets, host), self._loop).result()

    def show(self, frame: Frame) -> int:
        """Show a frame on every page and return its sequence number; a newer frame replaces one not yet sent.

        Its vertices are in the axes of the model. After `close` it does nothing. Raises InputError for a frame of
        another model.
        """
        if frame.vertices.shape != self._shape:
            raise InputError(
                f"frame: vertices {frame.vertices.shape}, {self._shape} expected; "
                f"give frames of the model {self._title!r} that the preview was made for"
            )
        motion = _motion(frame.coordinates[: self._lifts], frame.vertices)
        status = {
            "method": frame.method,
            "error": frame.error if math.isfinite(frame.error) else None,
            "elapsed": frame.elapsed,
            "converged": frame.converged,
        }
        with self._lock:
            self._sequence += 1
            self._latest = _Shown(self._sequence, motion, status)
            if not (self._flush_is_due or self._closed):
                self._flush_is_due = True  # one call on its way is enough, however many frames come meanwhile
                self._loop.call_soon_threadsafe(self._flush)
            return self._sequence

    def shown(self) -> int:
        """Return the highest sequence number that a page has said to have drawn; 0 before the first."""
        return self._newest_drawn

    def close(self) -> None:
        """Disconnect the pages, stop the thread and free the port; a second call does nothing."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        asyncio.run_coroutine_threadsafe(self._stop_serving(), self._loop).result()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    # Everything below runs in the server's thread.

    async def _serve(self, sockets: list[socket.socket], host: str) -> HTTPServer:
        application = Application(websocket_max_message_size=_MAX_MESSAGE, websocket_ping_interval=30)
        # A page elsewhere can make its own name resolve to 127.0.0.1; by the name it is told from this machine's pages.
        names = r"(127\.0\.0\.1|\[?::1\]?|localhost)" if host in _LOOPBACK else ".*"
        viewer = str(Path(meshcat.viewer_assets_path()) / "dist")
        application.add_handlers(
            names,
            [
                (r"/meshcat", _SceneSocket, {"commands": self._stage}),
                (r"/face", _FaceSocket, {"preview": self}),
                (r"/viewer/(.*)", _FreshFiles, {"path": viewer}),
                (r"/(.*)", _FreshFiles, {"path": str(_PAGE), "default_filename": "index.html"}),
            ],
        )
        server = HTTPServer(application)
        server.add_sockets(sockets)
        return server

    async def _stop_serving(self) -> None:
        self._server.stop()
        for face in self._faces:
            face.close(_GOING_AWAY, "the preview was closed")
        await self._server.close_all_connections()

    def _flush(self) -> None:
        with self._lock:
            self._flush_is_due = False
            latest = self._latest
        for face in list(self._faces):
            face.offer(latest)

    def _setup(self) -> str:
        return json.dumps(
            {
                "model": self._title,
                "lifts": self._lifts,
                "vertices": self._shape[0],
                "companions": self._companions,
                "sliders": [asdict(slider) for slider in sliders_of(self._table)],
                "values": dict(zip(self._table.names, self._values.tolist(), strict=True)),
            }
        )

    def _joined(self, face: _FaceSocket) -> None:
        self._faces.add(face)
        with self._lock:
            latest = self._latest
        face.offer(latest)

    def _left(self, face: _FaceSocket) -> None:
        self._faces.discard(face)

    def _drawn(self, sequence: int) -> None:
        self._newest_drawn = max(self._newest_drawn, sequence)

    def _moved(self, moves: list[tuple[str, float]], by: _FaceSocket) -> None:
        for name, value in moves:
            positions = self._table.aliases[name]
            self._values[list(positions)] = value
            for face in self._faces - {by}:
                face.moved |= {self._table.names[i]: value for i in positions}
        self._flush()
        for name, value in moves:
            self._on_input(name, value)


class _FreshFiles(StaticFileHandler):
    """Files that a browser asks about each time, so that a new release is seen at once."""

    def set_extra_headers(self, path: str) -> None:
        self.set_header("Cache-Control", "no-cache")


class _PageSocket(WebSocketHandler):
    """A websocket for pages of this server only."""

    def check_origin(self, origin: str) -> bool:
        """Say whether the page comes from the host and port that it talks to."""
        return bool(origin.partition("://")[2].lower() == self.request.headers.get("Host", "").lower())


class _SceneSocket(_PageSocket):
    """meshcat's own socket: sends the scene."""

    def initialize(self, commands: list[bytes]) -> None:
        self._commands = commands

    def open(self) -> None:
        for command in self._commands:
            self.write_message(command, binary=True)

    def on_message(self, message: str | bytes) -> None:
        """Ignore it: meshcat's viewer only ever answers requests for a picture, and none is made."""


class _FaceSocket(_PageSocket):
    """One page: what it was sent, what it has drawn."""

    def initialize(self, preview: Preview) -> None:
        self._preview = preview
        self._ticket = 0
        self._in_flight: dict[int, int] = {}  # ticket -> sequence number
        self._sent = -1
        self.moved: dict[str, float] = {}  # sliders that other pages moved and this one does not show yet

    def open(self) -> None:
        self.set_nodelay(True)
        self.write_message(self._preview._setup())
        self._preview._joined(self)

    def on_close(self) -> None:
        self._preview._left(self)

    def offer(self, latest: _Shown) -> None:
        """Send what the page does not show yet, unless enough is on its way."""
        if len(self._in_flight) >= MAX_IN_FLIGHT or (latest.sequence == self._sent and not self.moved):
            return
        self._ticket += 1
        status = json.dumps({"sequence": latest.sequence, **latest.status, "values": self.moved})
        message = _TICKET.pack(self._ticket) + latest.motion + status.encode()
        try:
            self.write_message(message, binary=True)
        except WebSocketClosedError:
            return  # on_close follows
        self._in_flight[self._ticket] = self._sent = latest.sequence
        self.moved = {}

    def on_message(self, message: str | bytes) -> None:
        """Take an acknowledgement or slider values; anything else ends the connection."""
        content = _json_object(message)
        moves = _checked_moves(content.get("inputs"), self._preview._table)
        ticket = content.get("drawn")
        if moves:
            self._preview._moved(moves, by=self)
        elif isinstance(ticket, int) and ticket in self._in_flight:
            self._acknowledge(ticket)
        else:
            self.close(_POLICY_VIOLATION, "not a message of this page")

    def _acknowledge(self, ticket: int) -> None:
        self._preview._drawn(self._in_flight[ticket])
        self._in_flight = {sent: sequence for sent, sequence in self._in_flight.items() if sent > ticket}
        self._preview._flush()


def _motion(lifts: npt.NDArray[np.floating], vertices: npt.NDArray[np.float32]) -> bytes:
    """Lift coordinates (lifts,), which companions move by, and vertices (n, 3) as they go over the wire."""
    return lifts.astype("<f4").tobytes() + vertices.astype("<f4", copy=False).tobytes()


def _json_object(message: str | bytes) -> dict[str, Any]:
    try:
        content = json.loads(message)
    except (ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


def _checked_moves(pairs: object, table: InputTable) -> list[tuple[str, float]]:
    """Return slider moves [(name, value)] that a page may make, or nothing if any of them is not one."""
    moves = []
    for pair in pairs if isinstance(pairs, list) else []:
        if not (isinstance(pair, list) and len(pair) == 2):
            return []
        name, value = pair
        positions = table.aliases.get(name) if isinstance(name, str) else None
        if positions is None or not isinstance(value, int | float):
            return []
        if not table.lower[positions[0]] <= value <= 1.0:
            return []
        moves.append((name, float(value)))
    return moves


def _listen(host: str, port: int | None) -> list[socket.socket]:
    if port is not None and not 0 < port < 65536:
        raise InputError(f"port {port} does not exist; give one from 1 to 65535, or none to take a free one")
    try:
        return bind_sockets(port or 0, address=host)
    except socket.gaierror as error:
        raise InputError(f"host {host!r} is not known ({error.strerror}); give an address of this machine") from error
    except OSError as error:
        raise InputError(
            f"port {port} of {host} cannot be used ({error.strerror}); "
            "stop the program that uses it or choose another port"
        ) from error


def _url(host: str, port: int) -> str:
    name = "localhost" if host in _ANY_ADDRESS else host
    return f"http://[{name}]:{port}/" if ":" in name else f"http://{name}:{port}/"
