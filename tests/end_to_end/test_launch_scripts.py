"""The commands of the README, as a user starts them."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from risorius_ros import environment

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "launch_scripts"
PATIENCE_S = 300.0  # the demo trains a model of the two cylinders

needs_own_environment = pytest.mark.skipif(
    Path(sys.prefix) != ROOT / ".venv", reason="runs from another environment than that of launch_scripts/setup"
)


@pytest.fixture
def variables(tmp_path: Path) -> dict[str, str]:
    own = {"ROS_DOMAIN_ID": str(1 + os.getpid() % 100), "ROS_LOG_DIR": str(tmp_path), "RISORIUS_TEST": str(tmp_path)}
    return environment.of_child() | own


def left_behind(variables: dict[str, str]) -> list[str]:
    """Command lines of processes that still carry the mark of a test."""
    mark = f"RISORIUS_TEST={variables['RISORIUS_TEST']}".encode()
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if mark in (process / "environ").read_bytes().split(b"\0"):
                found.append((process / "cmdline").read_text())
        except OSError:
            continue  # ended meanwhile, or another user's
    return found


@needs_own_environment
def test_second_setup_finds_nothing_to_do(variables: dict[str, str]) -> None:
    subprocess.run([SCRIPTS / "setup"], env=variables, check=True)
    stamp = ROOT / ".venv" / "installed"
    before = stamp.stat().st_mtime_ns
    again = subprocess.run([SCRIPTS / "setup"], env=variables, capture_output=True, text=True, check=True)
    assert again.stdout + again.stderr == ""
    assert stamp.stat().st_mtime_ns == before


@pytest.fixture
def broken_project(tmp_path: Path) -> Path:
    """A project that cannot be installed: setup gets as far as the packages, without any download."""
    (tmp_path / "launch_scripts").mkdir()
    shutil.copy(SCRIPTS / "setup", tmp_path / "launch_scripts")
    (tmp_path / "pyproject.toml").write_text("this is not TOML\n")
    return tmp_path / "launch_scripts" / "setup"


def test_an_interrupted_setup_does_not_look_complete(broken_project: Path, variables: dict[str, str]) -> None:
    for _ in range(2):
        ended = subprocess.run([broken_project], env=variables, capture_output=True, text=True)
        assert ended.returncode != 0
        assert "installing Python packages" in ended.stderr


def test_setup_passes_over_a_python_that_only_exists(
    broken_project: Path, variables: dict[str, str], tmp_path: Path
) -> None:
    shim = tmp_path / "shims" / "python3.12"
    shim.parent.mkdir()
    shim.write_text("#!/bin/sh\necho 'python3.12: command not found' >&2\nexit 127\n")
    shim.chmod(0o755)
    (shim.parent / "python3.11").symlink_to(sys.executable)
    path = f"{shim.parent}:{variables['PATH']}"
    ended = subprocess.run([broken_project], env=variables | {"PATH": path}, capture_output=True, text=True)
    assert "making .venv with Python 3." in ended.stderr
    assert "command not found" not in ended.stderr


def test_setup_refuses_a_python_that_cannot_do(broken_project: Path, variables: dict[str, str]) -> None:
    chosen = variables | {"PYTHON": "/bin/false"}
    ended = subprocess.run([broken_project], env=chosen, capture_output=True, text=True)
    assert ended.returncode == 2
    assert len(ended.stderr.splitlines()) == 1
    assert "PYTHON=/bin/false" in ended.stderr


def test_setup_uses_a_sourced_ros(broken_project: Path, variables: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "ros" / "rclpy").mkdir(parents=True)
    (tmp_path / "ros" / "rclpy" / "__init__.py").touch()
    sourced = variables | {"ROS_DISTRO": "jazzy", "PYTHONPATH": str(tmp_path / "ros")}
    ended = subprocess.run([broken_project], env=sourced, capture_output=True, text=True)
    assert "sourced ROS 2 jazzy" in ended.stderr
    assert "include-system-site-packages = true" in (tmp_path / ".venv" / "pyvenv.cfg").read_text()


@pytest.fixture(scope="module")
def demo_output(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that the demos of this module share, so that only the first one trains."""
    return tmp_path_factory.mktemp("demo")


@pytest.fixture
def demo(demo_output: Path) -> list[str | Path]:
    return [SCRIPTS / "demo", "--source", "cylinders", "--output", demo_output]


@needs_own_environment
@pytest.mark.slow
@pytest.mark.ros
def test_headless_demo_writes_pictures_of_what_it_received(
    demo: list[str | Path], demo_output: Path, variables: dict[str, str]
) -> None:
    pytest.importorskip("rclpy", reason="rclpy is not installed and no ROS 2 is sourced")
    ended = subprocess.run(
        [*demo, "--seconds", "5", "--headless"], env=variables, capture_output=True, text=True, timeout=PATIENCE_S
    )
    assert ended.returncode == 0, ended.stderr
    assert "300 weights sent" in ended.stdout
    pictures = list(demo_output.glob("*.png"))
    assert pictures
    assert all(picture.read_bytes().startswith(b"\x89PNG") for picture in pictures)
    assert not left_behind(variables)


@pytest.fixture
def playing_demo(
    demo: list[str | Path], variables: dict[str, str], tmp_path: Path
) -> Iterator[tuple[subprocess.Popen[bytes], Path]]:
    """A demo that runs until stopped, and the file with its messages."""
    pytest.importorskip("rclpy", reason="rclpy is not installed and no ROS 2 is sourced")
    log = tmp_path / "log"
    with log.open("wb") as file:
        process = subprocess.Popen(demo, env=variables, stdout=file, stderr=subprocess.STDOUT)
    deadline = time.monotonic() + PATIENCE_S
    while "Ctrl-C stops" not in log.read_text() and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.1)
    yield process, log
    process.kill()


@needs_own_environment
@pytest.mark.slow
@pytest.mark.ros
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_demo_stops_cleanly(
    playing_demo: tuple[subprocess.Popen[bytes], Path], variables: dict[str, str], number: signal.Signals
) -> None:
    process, log = playing_demo
    process.send_signal(number)
    assert process.wait(60.0) == 0, log.read_text()
    assert "Traceback" not in log.read_text()
    assert "http://" in log.read_text()
    assert not left_behind(variables)
