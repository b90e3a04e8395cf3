"""A slider that the mouse moves on the page changes the mesh that the node publishes."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import risorius

pytest.importorskip("rclpy", reason="rclpy is not installed and no ROS 2 is sourced")
pytest.importorskip("meshcat", reason="the extra `view` is not installed")

from tests.served_node import PATIENCE_S, served, spin_until

from risorius_ros import messages
from risorius_ros.client import FaceClient

pytestmark = [pytest.mark.ros, pytest.mark.browser]


def test_slider_moved_by_the_mouse_changes_the_published_mesh(
    chromium: Any, model_file: Path, synthetic_model: risorius.ReducedModel, tmp_path: Path
) -> None:
    with served(model_file, "--preview", log=tmp_path / "log") as node, FaceClient(engine=node.name) as client:
        client.ask({}, PATIENCE_S)
        url = re.search(r"http://127\.0\.0\.1:\d+/", node.output)
        assert url
        page = chromium.new_page(viewport={"width": 1000, "height": 700})
        page.goto(url[0])
        page.wait_for_function("() => window.preview && preview.shown >= 0")
        before = client.mesh
        slider = page.locator('[data-input="AU12"] .slider')
        box = slider.bounding_box()
        page.mouse.move(box["x"] + 0.2 * box["width"], box["y"] + 0.5 * box["height"])
        page.mouse.down()
        page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 0.5 * box["height"], steps=5)
        page.mouse.up()
        weight = float(page.locator('[data-input="AU12"] input').input_value())
        assert weight == pytest.approx(0.6, abs=0.03)
        expected = risorius.Engine(synthetic_model).evaluate({"AU12": weight}).vertices

        def arrived() -> bool:
            return client.mesh is not before and bool(
                np.abs(messages.from_rep103(client.mesh[1]) - expected).max() < 1e-6  # type: ignore[index]
            )

        spin_until(client, arrived)
        shown = page.evaluate("() => Array.from(preview.mesh.geometry.attributes.position.array)")
        assert np.abs(np.array(shown).reshape(-1, 3) - expected).max() < 1e-6
        page.close()
