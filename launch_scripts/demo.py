"""What launch_scripts/demo runs inside the environment: a small model, the node, the page, a loop of expressions."""

from __future__ import annotations

import argparse
import itertools
import os
import signal
import statistics
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from risorius import ReducedModel
    from risorius.expressions import ExpressionLoop
    from risorius_ros.client import FaceClient

ROOT = Path(__file__).resolve().parent.parent
RISORIUS = Path(sys.executable).with_name("risorius")
SNAPSHOTS = 104  # all single actions and named expressions of the head
HELD_OUT = 16  # the least that the error of a frame is told from
RATE_HZ = 60.0
LATENCIES_KEPT = 10_000
HEADLESS_SECONDS = 12.0
START_TIMEOUT_S = 60.0
STOP_TIMEOUT_S = 10.0
STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def main() -> int:
    catch_stop_signals()
    # Stay on this machine: the demo of a colleague would answer our weights, and theirs would move our face.
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    try:
        return run(parsed_arguments())
    except KeyboardInterrupt:
        say("stopped")
        return 0


def parsed_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="launch_scripts/demo", description=__doc__)
    parser.add_argument("--seconds", type=float, help="stop after this time; until Ctrl-C unless given")
    parser.add_argument("--headless", action="store_true", help="write pictures of what the node publishes")
    parser.add_argument("--source", default="builtin-draft", help="as of `risorius train`; by default %(default)s")
    parser.add_argument("--output", type=Path, default=ROOT / "demo_output", help="folder of model and pictures")
    arguments = parser.parse_args()
    if arguments.seconds is not None and not 0.0 < arguments.seconds < float("inf"):
        parser.error(f"--seconds {arguments.seconds}: give a positive number of seconds")
    if arguments.headless and arguments.seconds is None:
        arguments.seconds = HEADLESS_SECONDS
    return arguments


def run(arguments: argparse.Namespace) -> int:
    from risorius import Error
    from risorius.expressions import expression_loop

    try:
        path, model = trained_model(arguments.source, arguments.output)
        loop = expression_loop(model.inputs.names)
        if has_rclpy():
            pictures = play_on_node(path, loop, arguments.seconds)
        elif arguments.headless:
            pictures = evaluate_without_node(model, loop, arguments.seconds)
        else:
            return view_without_node(path, arguments.seconds)
        if arguments.headless:
            draw(pictures, loop, model, arguments.output)
    except Error as error:
        print(f"demo: {error}", file=sys.stderr)
        return error.exit_code
    return 0


def trained_model(source: str, folder: Path) -> tuple[Path, ReducedModel]:
    """Path and content of the model of `source` in `folder`, trained now if it is not there or of an old release."""
    import risorius

    path = folder / f"{Path(source).name}.h5"
    folder.mkdir(parents=True, exist_ok=True)
    say(f"source {source}, model {path}")
    if path.exists():
        try:
            return path, risorius.load(path)
        except risorius.FileFormatError as error:
            say(str(error))
            path.with_suffix(".snapshots.h5").unlink(missing_ok=True)  # of the same old release
    command = [RISORIUS, "train", source, "-o", path, "--snapshots", SNAPSHOTS, "--held-out", HELD_OUT]
    with running(command) as training:
        code = training.wait()
    if code:
        raise risorius.Error(f"training on {source} failed with exit code {code}; the reason is above")
    return path, risorius.load(path)


def has_rclpy() -> bool:
    try:
        import rclpy  # noqa: F401
    except ImportError as error:
        say(f"no ROS 2 node on this machine ({error}); everything else works")
        return False
    return True


class Exchange:
    """What went to the node and what came back.

    full: meshes (n, 3) as received, by the expression that they show in full.
    """

    def __init__(self) -> None:
        self.full: dict[str, Any] = {}
        self._sent = self._received = 0
        self._pending: dict[int, str | None] = {}
        self._latencies_ms: deque[float] = deque(maxlen=LATENCIES_KEPT)

    def sent(self, stamp: int, expression: str | None) -> None:
        """Note a message sent at `stamp`, and the expression that it shows in full, if any."""
        self._sent += 1
        self._pending[stamp] = expression

    def received(self, stamp: int, vertices: Any) -> None:
        """Note a mesh; one that answers a slider has a stamp that was not sent."""
        if stamp not in self._pending:
            return
        self._received += 1
        self._latencies_ms.append((time.time_ns() - stamp) * 1e-6)
        expression = self._pending.pop(stamp)
        if expression:
            self.full[expression] = vertices

    def summary(self) -> str:
        median = f"{statistics.median(self._latencies_ms):.1f} ms" if self._latencies_ms else "unknown"
        return f"{self._sent} weights sent, {self._received} meshes received, median latency {median}"


def play_on_node(path: Path, loop: ExpressionLoop, seconds: float | None) -> dict[str, Any]:
    """Run the node with its page and play the loop on it; returns the meshes it published at full expressions."""
    from risorius_ros import messages
    from risorius_ros.client import FaceClient

    exchange = Exchange()
    with (
        running([RISORIUS, "serve", path, "--preview"]) as node,
        stop_between_calls() as require_going_on,
        FaceClient(exchange.received) as client,
    ):

        def require_both() -> None:
            require_going_on()
            require_alive(node)

        wait_for(client, require_both)
        say(f"topics {', '.join(map(client.topic, (messages.ACTION_UNITS, messages.MESH, messages.TOPOLOGY)))}")
        say(f"playing {', '.join(expression.name for expression in loop.expressions)}; Ctrl-C stops")
        full = dict(full_expressions(loop, seconds)) if seconds else {}
        start = time.monotonic()
        for tick in itertools.count() if seconds is None else range(round(seconds * RATE_HZ)):
            require_both()
            exchange.sent(client.send(loop.weights(tick / RATE_HZ)), full.get(tick))
            while (rest := start + (tick + 1) / RATE_HZ - time.monotonic()) > 0.0:
                client.spin_once(rest)
    say(exchange.summary())
    return {name: messages.from_rep103(vertices) for name, vertices in exchange.full.items()}


def wait_for(client: FaceClient, require_both: Callable[[], None]) -> None:
    from risorius import Error

    deadline = time.monotonic() + START_TIMEOUT_S
    while client.topology is None or client.mesh is None:
        require_both()
        if time.monotonic() > deadline:
            raise Error(f"the node did not answer within {START_TIMEOUT_S:g} s; see its messages above")
        client.send({})
        client.spin_once(0.1)


def require_alive(node: subprocess.Popen[bytes]) -> None:
    from risorius import Error

    if node.poll() is not None:
        raise Error(f"the node ended with exit code {node.returncode}; the reason is above")


def view_without_node(path: Path, seconds: float | None) -> int:
    limit = [] if seconds is None else ["--seconds", seconds]
    with running([RISORIUS, "view", path, "--play", *limit]) as view:
        return view.wait()


def evaluate_without_node(model: ReducedModel, loop: ExpressionLoop, seconds: float) -> dict[str, Any]:
    """Return what the node would have published at full expressions."""
    from risorius import Engine

    engine = Engine(model)
    ticks = full_expressions(loop, seconds)
    return {name: engine.evaluate(loop.weights(tick / RATE_HZ)).vertices for tick, name in ticks}


def full_expressions(loop: ExpressionLoop, seconds: float) -> list[tuple[int, str]]:
    """Tick and name of each expression at the middle of its first turn, as far as `seconds` reach."""
    middles = [(index + 0.5) * loop.seconds_each for index in range(len(loop.expressions))]
    return [(int(middle * RATE_HZ), loop.expression(middle).name) for middle in middles if middle < seconds]


def draw(pictures: dict[str, Any], loop: ExpressionLoop, model: ReducedModel, folder: Path) -> None:
    """Write the pictures; raises risorius.Error when there are none."""
    from risorius import Error
    from risorius.companion import posed_companions
    from risorius.picture import draw_face, save_png

    if not pictures:
        raise Error("no mesh came back in time for a picture; give more --seconds")
    weights = {expression.name: expression.weights for expression in loop.expressions}
    for number, (name, vertices) in enumerate(pictures.items(), start=1):
        path = folder / f"{number:02}_{name.replace(' ', '_')}.png"
        parameters = model.inputs.to_parameters(model.inputs.weights(weights[name]))
        lifts = model.poses.lift_coordinates(parameters[len(model.inputs.muscles) :])
        picture = draw_face(
            vertices,
            model.triangles,
            keep_in_view=model.rest_vertices,
            colours=model.colours,
            companions=posed_companions(model.companions, model.poses, lifts),
        )
        save_png(path, picture)
        say(f"wrote {path}")


@contextmanager
def running(command: Sequence[object]) -> Iterator[subprocess.Popen[bytes]]:
    """Run a command in a process group of its own; interrupt the group at the end, and end what is left of it."""
    from risorius_ros import environment

    process = subprocess.Popen([*map(str, command)], env=environment.of_child(), start_new_session=True)
    try:
        yield process
    finally:
        for number in STOP_SIGNALS:  # a second Ctrl-C must not leave processes behind
            signal.signal(number, signal.SIG_IGN)
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGINT)
            with suppress(subprocess.TimeoutExpired):
                process.wait(STOP_TIMEOUT_S)
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        catch_stop_signals()


@contextmanager
def stop_between_calls() -> Iterator[Callable[[], None]]:
    """Return what raises KeyboardInterrupt once a stop signal has come: one raised amid rclpy's C++ is lost there."""
    come: list[int] = []
    for number in STOP_SIGNALS:
        signal.signal(number, lambda number, _: come.append(number))

    def require_going_on() -> None:
        if come:
            raise KeyboardInterrupt

    try:
        yield require_going_on
    finally:
        catch_stop_signals()


def catch_stop_signals() -> None:
    for number in STOP_SIGNALS:
        signal.signal(number, signal.default_int_handler)


def say(text: str) -> None:
    print(f"demo: {text}", flush=True)


if __name__ == "__main__":
    sys.exit(main())
