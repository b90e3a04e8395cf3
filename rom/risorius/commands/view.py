"""`risorius view`: the face in a browser, moved by sliders."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from risorius.commands.settings import SceneFile, engine_for
from risorius.errors import InputError

if TYPE_CHECKING:
    from risorius.engine import Engine, Frame

_PLAYING_STEP = 1.0 / 60.0  # seconds between frames of the expression loop
_IDLE_STEP = 1.0  # longest wait for a slider before the clock is looked at


class _Moves:
    """Newest value of each slider since the last look; handed from the server's thread to the engine's."""

    def __init__(self) -> None:
        self._values: dict[str, float] = {}
        self._changed = threading.Condition()

    def put(self, name: str, value: float) -> None:
        """Remember a move; of one slider only the newest is kept, in the order of the newest."""
        with self._changed:
            self._values.pop(name, None)
            self._values[name] = value
            self._changed.notify()

    def take(self, timeout: float) -> list[tuple[str, float]]:
        """Return the moves since the last call, waiting up to `timeout` seconds for the first."""
        with self._changed:
            self._changed.wait_for(lambda: bool(self._values), timeout)
            moves = list(self._values.items())
            self._values.clear()
        return moves


def view(
    model: Annotated[Path, typer.Argument(help="Model file.")],
    host: Annotated[str, typer.Option(help="Address to listen on; 0.0.0.0 lets other machines in.")] = "127.0.0.1",
    port: Annotated[int | None, typer.Option(help="Port of the page; a free one unless given.")] = None,
    play: Annotated[bool, typer.Option("--play", help="Play expressions until a slider is moved.")] = False,
    seconds: Annotated[float | None, typer.Option(help="Stop after this time; until Ctrl-C unless given.")] = None,
    scene: SceneFile = None,
) -> None:
    """Serve a page that shows the face and moves it by sliders."""
    if seconds is not None and not seconds > 0.0:
        raise InputError(f"--seconds: {seconds} given; give a positive number of seconds")
    from risorius.preview import Preview

    engine = engine_for(model, scene)
    moves = _Moves()
    preview = Preview(engine.model, host=host, port=port, on_input=moves.put)
    try:
        typer.echo(f"{engine.model.name}: open {preview.url} in a browser; Ctrl-C stops")
        _drive(engine, moves, preview.show, play=play, seconds=seconds)
    except KeyboardInterrupt:
        typer.echo("stopped")  # the usual way to end it, not a failure
    finally:
        preview.close()


def _drive(engine: Engine, moves: _Moves, show: Callable[[Frame], int], *, play: bool, seconds: float | None) -> None:
    """Evaluate what the sliders or the expression loop ask for; the only thread that touches the engine."""
    from risorius.expressions import expression_loop
    from risorius.stream import InputGate

    gate = InputGate(engine.model.inputs)
    loop = expression_loop(engine.inputs) if play else None
    weights = gate.weights([])
    show(engine.evaluate(weights))
    start = time.monotonic()
    while seconds is None or time.monotonic() - start < seconds:
        left = float("inf") if seconds is None else max(0.0, start + seconds - time.monotonic())
        moved = moves.take(min(_PLAYING_STEP if loop else _IDLE_STEP, left))
        if moved:
            loop = None
            weights = gate.weights(moved, base=weights)
            show(engine.evaluate(weights))
        elif loop:
            show(engine.evaluate(loop.weights(time.monotonic() - start)))
