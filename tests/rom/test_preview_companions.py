"""Colours and companions on the page: what is asserted are numbers and pixels read back from a real browser."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from io import BytesIO
from typing import Any

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the extra `view` is not installed")
from PIL import Image

from risorius import Engine, ReducedModel
from risorius.companion import JAW, SKULL, Companion
from risorius.preview import Preview

pytestmark = pytest.mark.browser

PATIENCE = 60  # seconds before a test that waits for the other side gives up
BROAD_YAWN = {"jaw_open": 0.9, "jaw_sideways": -0.6, "jaw_forward": 0.4, "AU12": 0.5}
BLUE, GREEN = (20, 40, 230), (20, 210, 30)


def ball(centre: tuple[float, float, float], radius: float, colour: tuple[int, int, int], moves_with: str) -> Companion:
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    triangles = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    return Companion(centre + radius * axes, triangles, np.full((6, 3), colour, dtype=np.uint8), moves_with)


@pytest.fixture
def seen(synthetic_model: ReducedModel) -> ReducedModel:
    """The synthetic model, green, with a blue eye above it and a blue tooth that goes with the jaw."""
    companions = {"eye": ball((0.0, 0.05, 0.0), 0.02, BLUE, SKULL), "tooth": ball((0.02, -0.12, 0.02), 0.01, BLUE, JAW)}
    colours = np.full(synthetic_model.rest_vertices.shape, GREEN, dtype=np.uint8)
    return replace(synthetic_model, colours=colours, companions=companions)


@pytest.fixture
def open_page(chromium: Any) -> Iterator[Callable[[ReducedModel, dict[str, float]], Any]]:
    """Open a page that shows a model with some weights; at the end none of the pages may have complained."""
    context = chromium.new_context(viewport={"width": 1000, "height": 700})
    complaints: list[str] = []
    previews: list[Preview] = []

    def opened(model: ReducedModel, weights: dict[str, float]) -> Any:
        engine = Engine(model)
        previews.append(Preview(engine.model, on_input=lambda *_: None))
        sequence = previews[-1].show(engine.evaluate(weights))
        page = context.new_page()
        page.set_default_timeout(1000 * PATIENCE)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("console", lambda entry: complaints.append(entry.text) if entry.type == "error" else None)
        page.goto(previews[-1].url)
        page.wait_for_function("sequence => window.preview && preview.shown === sequence", arg=sequence)
        return page

    yield opened
    context.close()
    for preview in previews:
        preview.close()
    assert complaints == []


def drawn_points(page: Any, name: str) -> np.ndarray:
    """Points (k, 3) of a companion in the frame of the model, where the page draws them."""
    flat = page.evaluate(
        """name => {
            const thing = preview.viewer.scene_tree.find(["meshcat", "face", name, "<object>"]).object;
            const position = thing.geometry.attributes.position, points = [];
            const place = preview.mesh.matrixWorld.clone().invert().multiply(thing.matrixWorld);
            for (let i = 0; i < position.count; i++) {
                points.push(new MeshCat.THREE.Vector3().fromBufferAttribute(position, i).applyMatrix4(place).toArray());
            }
            return points;
        }""",
        name,
    )
    return np.array(flat)


def picture(page: Any) -> np.ndarray:
    """What the page shows beside the panel, (height, width, 3)."""
    clip = {"x": 0, "y": 0, "width": 640, "height": 660}
    return np.asarray(Image.open(BytesIO(page.screenshot(clip=clip))).convert("RGB")).astype(int)


def shades(pixels: np.ndarray, dominant: int) -> np.ndarray:
    """Pixels in which one component is far above the others."""
    others = np.delete(pixels, dominant, axis=2).max(axis=2)
    return pixels[pixels[:, :, dominant] > others + 40]


@pytest.mark.parametrize("weights", [{}, BROAD_YAWN])
def test_companions_are_where_skull_and_jaw_put_them(
    seen: ReducedModel, open_page: Callable[..., Any], weights: dict[str, float]
) -> None:
    page = open_page(seen, weights)
    coordinates = Engine(seen).evaluate(weights).coordinates
    for name, companion in seen.companions.items():
        expected = companion.posed(seen.poses, coordinates)
        assert np.abs(drawn_points(page, name) - expected).max() < 1e-7
    assert (np.abs(drawn_points(page, "tooth") - seen.companions["tooth"].points).max() > 0.01) == bool(weights)


def test_face_and_companions_have_their_colours(seen: ReducedModel, open_page: Callable[..., Any]) -> None:
    pixels = picture(open_page(seen, {}))
    assert len(shades(pixels, 1)) > 20_000
    assert len(shades(pixels, 2)) > 2_000


def test_colours_of_vertices_look_as_the_same_colour_of_all_skin_does(
    synthetic_model: ReducedModel, open_page: Callable[..., Any]
) -> None:
    colours = np.full(synthetic_model.rest_vertices.shape, (0xD9, 0xA5, 0x8A), dtype=np.uint8)
    plain, coloured = (
        picture(open_page(model, {})) for model in (synthetic_model, replace(synthetic_model, colours=colours))
    )
    assert np.abs(coloured - plain).max() <= 1


def test_companions_fit_into_the_window_too(seen: ReducedModel, open_page: Callable[..., Any]) -> None:
    large = {"scalp": ball((0.0, 0.0, -0.1), 0.15, BLUE, SKULL)}
    page = open_page(replace(seen, companions=large), {})
    projected = np.array(
        page.evaluate(
            """() => {
                const { array } = preview.companions[0][0].geometry.attributes.position, seen = [];
                for (let i = 0; i < array.length; i += 3) {
                    const p = new MeshCat.THREE.Vector3().fromArray(array, i);
                    seen.push(p.applyMatrix4(preview.mesh.matrixWorld).project(preview.viewer.camera).toArray());
                }
                return seen;
            }"""
        )
    )
    assert np.abs(projected[:, 1]).max() < 1.0
    assert -1.0 < projected[:, 0].min() < projected[:, 0].max() < 1.0 - 2.0 * 360 / 1000
