"""Sub-command `risorius serve`."""

from __future__ import annotations

import json
import os
import platform
import sys
from pathlib import Path
from typing import Annotated

import typer

from risorius.errors import InputError, MissingExtraError


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})(serve)


def serve(
    context: typer.Context,
    model: Annotated[Path, typer.Argument(help="Model file of `risorius train`.")],
    preview: Annotated[bool, typer.Option(help="Serve a page that shows the face and has sliders.")] = False,
    port: Annotated[int | None, typer.Option(help="Port of the page; a free one unless given.")] = None,
    frame_id: Annotated[str, typer.Option(help="Frame of the published vertices.")] = "face",
    scene: Annotated[Path | None, typer.Option(help="Scene file (YAML); everything unless given.")] = None,
) -> None:
    """Run the ROS 2 node face_engine; what follows --ros-args goes to ROS."""
    if context.args and context.args[0] != "--ros-args":
        raise typer.BadParameter(f"{context.args[0]!r} is not an option of serve; ROS arguments follow --ros-args")
    _require_rclpy()
    parameters = {
        "model_path": str(model),
        "scene_path": str(scene or ""),
        "preview": preview,
        "preview_port": port or 0,
        "frame_id": frame_id,
    }
    # JSON is YAML: a path stays text however it is spelled.
    settings = [text for name, value in parameters.items() for text in ("-p", f"{name}:={json.dumps(value)}")]
    # The node needs variables that numpy reads when it is imported, which it is by now: start Python afresh.
    arguments = [sys.executable, "-m", "risorius_ros", "--ros-args", *settings, *context.args[1:]]
    os.execv(sys.executable, arguments)


def _require_rclpy() -> None:
    try:
        import rclpy  # noqa: F401
    except ImportError as error:
        system, machine = platform.system(), platform.machine()
        if (system, machine) == ("Linux", "x86_64"):
            raise MissingExtraError("serve", "ros", "rclpy") from error
        raise InputError(
            f"serve needs rclpy, whose wheels exist for Linux on x86_64 and not for {system} on {machine}; "
            "source a ROS 2 installation, or look at the model with: risorius view MODEL"
        ) from error
