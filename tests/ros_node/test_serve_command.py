"""`risorius serve` where there is no rclpy."""

from __future__ import annotations

import platform
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

import risorius
from risorius_ros import commands


@pytest.fixture
def app(monkeypatch: pytest.MonkeyPatch) -> typer.Typer:
    monkeypatch.setitem(sys.modules, "rclpy", None)  # importing it now fails
    app = typer.Typer()
    app.callback()(lambda: None)
    commands.register(app)
    return app


def on_machine(monkeypatch: pytest.MonkeyPatch, system: str, machine: str) -> None:
    monkeypatch.setattr(platform, "system", lambda: system)
    monkeypatch.setattr(platform, "machine", lambda: machine)


def test_registering_the_command_does_not_import_rclpy() -> None:
    program = "import sys, risorius_ros.commands; sys.exit('rclpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program]).returncode == 0


def test_without_rclpy_the_extra_is_named(app: typer.Typer, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    on_machine(monkeypatch, "Linux", "x86_64")
    error = CliRunner().invoke(app, ["serve", str(tmp_path / "model.h5")]).exception
    assert isinstance(error, risorius.MissingExtraError)
    assert "risorius[ros]" in str(error)


@pytest.mark.parametrize(("system", "machine"), [("Darwin", "arm64"), ("Windows", "AMD64"), ("Linux", "aarch64")])
def test_where_there_are_no_wheels_the_other_ways_are_named(
    app: typer.Typer, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, system: str, machine: str
) -> None:
    on_machine(monkeypatch, system, machine)
    error = CliRunner().invoke(app, ["serve", str(tmp_path / "model.h5")]).exception
    assert isinstance(error, risorius.InputError)
    assert f"{system} on {machine}" in str(error)
    assert "risorius view" in str(error)
