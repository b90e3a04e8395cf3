"""The live preview in a real browser: what is asserted are numbers read back from the page."""

from __future__ import annotations

import os
import queue
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the extra `view` is not installed")
from risorius import Engine, ReducedModel
from risorius.preview import Preview, sliders, stage

pytestmark = pytest.mark.browser

PATIENCE = 60  # seconds before a test that waits for the other side gives up
EXPRESSION = {"AU12_L": 0.9, "AU12_R": 0.2, "jaw_open": 0.4, "jaw_sideways": -0.3}


class Stand:
    """A preview of the synthetic model, its engine and the slider moves that arrived."""

    def __init__(self, model: ReducedModel) -> None:
        self.engine = Engine(model)
        self.moves: queue.SimpleQueue[tuple[str, float]] = queue.SimpleQueue()
        self.preview = Preview(self.engine.model, on_input=lambda name, value: self.moves.put((name, value)))

    def show(self, **weights: float) -> int:
        return self.preview.show(self.engine.evaluate(weights))

    def next_move(self) -> tuple[str, float]:
        return self.moves.get(timeout=PATIENCE)


@pytest.fixture
def stand(synthetic_model: ReducedModel) -> Iterator[Stand]:
    stand = Stand(synthetic_model)
    with closing(stand.preview):
        yield stand


@pytest.fixture
def open_page(chromium: Any, stand: Stand) -> Iterator[Callable[..., Any]]:
    """Open a page that shows the latest frame; at the end none of the pages may have complained."""
    context = chromium.new_context(viewport={"width": 1000, "height": 700})
    complaints: list[str] = []

    def listen(page: Any) -> None:
        page.set_default_timeout(1000 * PATIENCE)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("console", lambda entry: complaints.append(entry.text) if entry.type == "error" else None)

    context.on("page", listen)

    def opened() -> Any:
        page = context.new_page()
        page.goto(stand.preview.url)
        page.wait_for_function("() => window.preview && preview.shown >= 0")
        return page

    opened.context = context  # type: ignore[attr-defined]
    yield opened
    context.close()
    assert complaints == []


def wait_shown(page: Any, sequence: int) -> None:
    page.wait_for_function("sequence => preview.shown === sequence", arg=sequence)


def attribute(page: Any, name: str) -> np.ndarray:
    flat = page.evaluate("name => Array.from(preview.mesh.geometry.attributes[name].array)", name)
    return np.array(flat).reshape(-1, 3)


def slider_value(page: Any, name: str) -> float:
    return float(page.locator(f'[data-input="{name}"] input').input_value())


def click_slider(page: Any, name: str, share: float) -> None:
    slider = page.locator(f'[data-input="{name}"] .slider')
    box = slider.bounding_box()
    slider.click(position={"x": share * box["width"], "y": 0.5 * box["height"]})


def area_weighted_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (vertices[triangles[:, k]].astype(np.float64) for k in range(3))
    normals = np.zeros((len(vertices), 3))
    for k in range(3):
        np.add.at(normals, triangles[:, k], np.cross(b - a, c - a))
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


@pytest.mark.parametrize("weights", [{}, EXPRESSION, {"AU12": 1.0, "AU27": 1.0}])
def test_page_shows_the_engines_vertices_and_their_normals(
    stand: Stand, open_page: Callable[..., Any], weights: dict[str, float]
) -> None:
    page = open_page()
    wait_shown(page, stand.show(**weights))
    expected = stand.engine.evaluate(weights).vertices
    assert np.abs(attribute(page, "position") - expected).max() < 1e-6
    normals = area_weighted_normals(expected, stand.engine.triangles)
    assert np.abs(attribute(page, "normal") - normals).max() < 1e-4  # the vertices carry 4e-9 m, triangles span 6 mm


def test_normals_belong_to_the_vertices_of_the_same_frame(stand: Stand, open_page: Callable[..., Any]) -> None:
    page = open_page()
    wait_shown(page, stand.show(**EXPRESSION))
    normals = area_weighted_normals(attribute(page, "position"), stand.engine.triangles)
    assert np.abs(attribute(page, "normal") - normals).max() < 1e-6


def test_slider_moved_by_mouse_moves_the_face(stand: Stand, open_page: Callable[..., Any]) -> None:
    page = open_page()
    click_slider(page, "AU12", 0.7)
    name, value = stand.next_move()
    assert name == "AU12"
    assert value == pytest.approx(0.7, abs=0.02)
    wait_shown(page, stand.show(AU12=value))
    assert np.abs(attribute(page, "position") - stand.engine.evaluate({"AU12": value}).vertices).max() < 1e-6
    assert slider_value(page, "AU12_L") == slider_value(page, "AU12_R") == pytest.approx(value)


def test_jaw_slides_both_ways(stand: Stand, open_page: Callable[..., Any]) -> None:
    page = open_page()
    click_slider(page, "jaw_sideways", 0.25)
    name, value = stand.next_move()
    assert name == "jaw_sideways"
    assert value == pytest.approx(-0.5, abs=0.04)


def test_wheel_brings_the_last_slider_into_a_low_window_and_leaves_the_face(
    stand: Stand, open_page: Callable[..., Any]
) -> None:
    page = open_page()
    page.set_viewport_size({"width": 1000, "height": 180})
    last = page.locator('[data-input="jaw_sideways"] .slider')
    assert last.bounding_box()["y"] > 180
    page.mouse.move(900, 90)
    page.mouse.wheel(0, 130)
    page.wait_for_function("() => document.querySelector('.dg.main > ul').scrollTop > 0")
    box = last.bounding_box()
    assert 0 < box["y"] < 160
    assert page.evaluate("() => [scrollX, scrollY]") == [0, 0]
    assert page.locator(".close-button").bounding_box()["y"] == pytest.approx(160, abs=5)
    page.mouse.click(box["x"] + 0.25 * box["width"], box["y"] + 0.5 * box["height"])
    assert stand.next_move() == ("jaw_sideways", pytest.approx(-0.5, abs=0.04))


def test_neutral_button_sets_every_slider_to_zero(stand: Stand, open_page: Callable[..., Any]) -> None:
    page = open_page()
    click_slider(page, "AU26", 0.6)
    stand.next_move()
    page.get_by_text("neutral", exact=True).click()
    names = [slider.name for slider in sliders.sliders_of(stand.engine.model.inputs)]
    assert [stand.next_move() for _ in names] == [(name, 0.0) for name in names]
    assert slider_value(page, "AU26") == 0.0


def test_slider_of_one_side_is_in_a_closed_folder_and_moves_that_side_only(
    stand: Stand, open_page: Callable[..., Any]
) -> None:
    page = open_page()
    in_closed_folder = page.locator('.closed [data-input="AU12_L"]')
    assert in_closed_folder.count() == 1
    page.get_by_text("left, right").click()
    assert in_closed_folder.count() == 0
    click_slider(page, "AU12_L", 0.5)
    name, value = stand.next_move()
    assert name == "AU12_L"
    assert slider_value(page, "AU12_R") == 0.0
    assert slider_value(page, "AU12") == pytest.approx(value / 2, abs=0.01)
    assert page.locator("li", has=page.locator('[data-input="AU12_L"]')).last.get_attribute("title") == (
        "AU12_L: Lip Corner Puller"
    )


def test_two_pages_show_the_same_sliders_and_do_not_answer_each_other(
    stand: Stand, open_page: Callable[..., Any]
) -> None:
    first, second = open_page(), open_page()
    click_slider(first, "AU12", 0.4)
    name, value = stand.next_move()
    sequence = stand.show(**{name: value})
    wait_shown(first, sequence)
    wait_shown(second, sequence)
    assert slider_value(second, "AU12") == pytest.approx(value)
    click_slider(second, "AU26", 0.9)
    assert stand.next_move()[0] == "AU26"
    assert stand.moves.empty()


def test_page_that_joins_late_shows_the_latest_frame_and_sliders(stand: Stand, open_page: Callable[..., Any]) -> None:
    first = open_page()
    click_slider(first, "AU12", 0.4)
    name, value = stand.next_move()
    wait_shown(first, stand.show(**EXPRESSION))
    late = open_page()
    assert np.abs(attribute(late, "position") - stand.engine.evaluate(EXPRESSION).vertices).max() < 1e-6
    assert slider_value(late, name) == pytest.approx(value)


def test_flood_ends_with_the_latest_frame_in_bounded_memory(stand: Stand, open_page: Callable[..., Any]) -> None:
    page = open_page()
    page.evaluate("() => { window.arrived = 0; preview.socket.addEventListener('message', () => { arrived++; }); }")
    wait_shown(page, stand.show())
    frames = [stand.engine.evaluate({"AU12": k / 20}) for k in range(21)]
    before = resident_bytes()
    for k in range(5000):
        sequence = stand.preview.show(frames[k % 21])
    wait_shown(page, sequence)
    assert resident_bytes() - before < 20e6
    assert page.evaluate("() => arrived") < 5000
    assert np.abs(attribute(page, "position") - frames[4999 % 21].vertices).max() < 1e-6


def test_page_that_is_not_displayed_is_sent_nothing_more_and_catches_up(
    stand: Stand, open_page: Callable[..., Any]
) -> None:
    """A frame that is not displayed gets no animation frames from the browser, as a hidden tab does."""
    outer = open_page.context.new_page()  # type: ignore[attr-defined]
    outer.set_content(f'<iframe src="{stand.preview.url}" width="900" height="600"></iframe>')
    inner = outer.frames[1]
    inner.wait_for_function("() => window.preview && preview.shown === 0")
    inner.evaluate("() => { window.ticks = 0; (function tick() { ticks++; requestAnimationFrame(tick); })(); }")
    outer.evaluate("() => { document.querySelector('iframe').style.display = 'none'; }")
    # The browser may still grant a few animation frames: go on when they have stopped.
    inner.wait_for_function(
        "() => { const same = window.last === ticks; window.last = ticks; return same; }", polling=200
    )
    inner.evaluate("() => { window.arrived = 0; preview.socket.addEventListener('message', () => { arrived++; }); }")
    for _ in range(200):
        sequence = stand.show(**EXPRESSION)
    inner.wait_for_function("() => arrived > 0", polling=20)
    assert inner.evaluate("() => [arrived <= 2, preview.shown]") == [True, 0]
    outer.evaluate("() => { document.querySelector('iframe').style.display = ''; }")
    wait_shown(inner, sequence)


def test_face_fills_the_window_upright_beside_the_panel(stand: Stand, open_page: Callable[..., Any]) -> None:
    page = open_page()
    projected = np.array(
        page.evaluate(
            """() => {
                const { mesh, viewer } = preview, position = mesh.geometry.attributes.position, seen = [];
                mesh.updateMatrixWorld(true);
                for (let i = 0; i < position.count; i++) {
                    const p = new MeshCat.THREE.Vector3().fromBufferAttribute(position, i);
                    seen.push(p.applyMatrix4(mesh.matrixWorld).project(viewer.camera).toArray());
                }
                return seen;
            }"""
        )
    )
    rest = stand.engine.model.rest_vertices
    assert projected[rest[:, 1].argmax(), 1] > 0.5 > -0.5 > projected[rest[:, 1].argmin(), 1]
    panel = 1.0 - 2.0 * 360 / 1000
    assert np.abs(projected[:, 1]).max() < 1.0
    assert -1.0 < projected[:, 0].min() < projected[:, 0].max() < panel
    fills = np.ptp(projected[:, 1]) / 2.0, np.ptp(projected[:, 0]) / (1.0 + panel)
    assert max(fills) > 0.75
    top = rest[:, 1] == rest[:, 1].max()
    left_of_person = rest[top, 0].argmax(), rest[top, 0].argmin()
    assert projected[top][left_of_person[0], 0] > projected[top][left_of_person[1], 0]


def test_scene_is_a_portrait_without_grid_and_axes(stand: Stand, open_page: Callable[..., Any]) -> None:
    page = open_page()
    scene = page.evaluate(
        """() => {
            const { viewer, mesh } = preview, find = (path) => viewer.scene_tree.find(path).object;
            return {
                fov: viewer.camera.fov, grid: find(["Grid"]).visible, axes: find(["Axes"]).visible,
                doubleSided: mesh.material.side === MeshCat.THREE.DoubleSide,
            };
        }"""
    )
    assert scene == {"fov": stage.FIELD_OF_VIEW, "grid": False, "axes": False, "doubleSided": True}


def test_status_line_tells_method_error_and_time(stand: Stand, open_page: Callable[..., Any]) -> None:
    page = open_page()
    frame = stand.engine.evaluate(EXPRESSION)
    wait_shown(page, stand.preview.show(frame))
    name, method, error, time = page.locator("#status").inner_text().split(" · ")
    assert (name, method) == ("synthetic", "polynomial")
    assert float(error.removeprefix("error ≤ ").removesuffix(" mm")) == pytest.approx(1e3 * frame.error, rel=0.05)
    assert float(time.removesuffix(" µs")) == pytest.approx(1e6 * frame.elapsed, abs=1.0)


def test_page_tells_that_the_server_is_gone(chromium: Any, synthetic_model: ReducedModel) -> None:
    stand = Stand(synthetic_model)
    page = chromium.new_page()
    page.goto(stand.preview.url)
    page.wait_for_function("() => window.preview && preview.shown === 0")
    stand.preview.close()
    page.get_by_text("connection lost").wait_for()
    page.close()


def resident_bytes() -> int:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")
