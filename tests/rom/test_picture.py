"""Pictures drawn off screen, and the command that writes them."""

from __future__ import annotations

import ctypes.util
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pyvista", reason="the extra `view` is not installed")
from PIL import Image

from risorius import InputError, MissingExtraError, ReducedModel
from risorius.picture import draw_face, save_png

SIZE = (160, 120)
RISORIUS = [sys.executable, "-c", "from risorius.cli import main; main()"]


def ball(radius: float = 0.08) -> tuple[np.ndarray, np.ndarray]:
    """A sphere as a face: 24 x 48 vertices, outward triangles."""
    polar, around = np.meshgrid(np.linspace(0.0, np.pi, 24), np.linspace(0.0, 2.0 * np.pi, 48), indexing="ij")
    vertices = radius * np.stack(
        [np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=-1
    ).reshape(-1, 3)
    corner = (48 * np.arange(23)[:, None] + np.arange(47)).ravel()
    triangles = np.concatenate(
        [np.column_stack([corner, corner + 48, corner + 49]), np.column_stack([corner, corner + 49, corner + 1])]
    )
    return vertices, triangles


def is_face(picture: np.ndarray) -> np.ndarray:
    """Pixels that are skin: redder than the grey-blue background."""
    return picture[..., 0].astype(int) > picture[..., 2].astype(int) + 15


def test_picture_has_the_size_asked_for_and_shows_the_whole_face() -> None:
    face = is_face(draw_face(*ball(), view="front", size=SIZE))
    assert face.shape == (120, 160)
    rows, columns = np.flatnonzero(face.any(axis=1)), np.flatnonzero(face.any(axis=0))
    assert 0 < rows[0] < rows[-1] < 119
    assert np.ptp(rows) == pytest.approx(0.88 * 120, abs=6)
    assert np.ptp(columns) == pytest.approx(np.ptp(rows), abs=2)


def test_face_is_upright_with_its_left_on_the_viewers_right() -> None:
    vertices, triangles = ball()
    vertices[:, 0] += np.where(vertices[:, 1] > 0.04, 0.05, 0.0)  # a lump up and to the person's left
    face = is_face(draw_face(vertices, triangles, view="front", size=SIZE))
    columns = np.arange(160)
    assert columns[face[20]].mean() > columns[face[80]].mean() + 10


@pytest.mark.parametrize("view", ["side", "three-quarter"])
def test_nose_points_to_the_viewers_right_in_views_from_the_persons_right(view: str) -> None:
    vertices, triangles = ball()
    vertices[:, 2] += np.where(vertices[:, 2] > 0.07, 0.05, 0.0)
    face = is_face(draw_face(vertices, triangles, view=view, size=SIZE))
    rows = np.arange(120)
    left, right = (np.ptp(rows[face[:, column]]) for column in np.flatnonzero(face.any(axis=0))[[4, -5]])
    assert right < left


def test_light_comes_from_the_viewers_upper_left() -> None:
    picture = draw_face(*ball(), view="front", size=SIZE).astype(float).mean(axis=2)
    assert picture[40, 60] > picture[80, 100] + 20


def test_winding_the_other_way_does_not_make_holes() -> None:
    vertices, triangles = ball()
    same = is_face(draw_face(vertices, triangles, size=SIZE)) == is_face(
        draw_face(vertices, triangles[:, ::-1], size=SIZE)
    )
    assert same.mean() > 0.99


def test_pictures_with_the_same_points_in_view_share_the_camera() -> None:
    vertices, triangles = ball()
    smaller = is_face(draw_face(0.5 * vertices, triangles, view="front", size=SIZE, keep_in_view=vertices))
    larger = is_face(draw_face(vertices, triangles, view="front", size=SIZE, keep_in_view=vertices))
    assert smaller.sum() / larger.sum() == pytest.approx(0.25, abs=0.03)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"view": "top"}, "front, three-quarter, side"),
        ({"size": (0, 100)}, "16 to 8192"),
        ({"size": (100, 9000)}, "16 to 8192"),
        ({"vertices": np.full((4, 3), np.nan)}, "not finite"),
        ({"vertices": np.zeros((4, 2))}, r"\(n, 3\)"),
        ({"triangles": np.array([[0, 1, 4]])}, "from 0 to 3"),
        ({"triangles": np.zeros((0, 3), dtype=int)}, "must be some"),
    ],
)
def test_bad_arguments_are_refused(change: dict[str, object], message: str) -> None:
    arguments = {"vertices": np.eye(4, 3), "triangles": np.array([[0, 1, 2]])} | change
    with pytest.raises(InputError, match=message):
        draw_face(**arguments)  # type: ignore[arg-type]


def test_missing_package_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(MissingExtraError, match=r"risorius\[view\]"):
        draw_face(*ball(), size=SIZE)


def test_png_holds_the_picture_exactly_and_nothing_is_left_beside_it(tmp_path: Path) -> None:
    picture = np.random.default_rng(3).integers(0, 256, (20, 30, 3), dtype=np.uint8)
    save_png(tmp_path / "face.png", picture)
    assert (np.asarray(Image.open(tmp_path / "face.png")) == picture).all()
    assert [path.name for path in tmp_path.iterdir()] == ["face.png"]


@pytest.fixture(scope="module")
def model_file(synthetic_model: ReducedModel, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "model.h5"
    synthetic_model.save(path)
    return path


def render(model_file: Path, output: Path, *options: str) -> subprocess.CompletedProcess[str]:
    command = [*RISORIUS, "render", str(model_file), "-o", str(output), *options]
    return subprocess.run(command, capture_output=True, text=True, timeout=120)


def test_render_command_writes_a_picture_without_a_word_on_stderr(model_file: Path, tmp_path: Path) -> None:
    settings = ("--set", "AU12=0.8", "--set", "jaw_open=0.3", "--set", "zygomaticus_major_L=0.1")
    done = render(model_file, tmp_path / "face.png", *settings, "--size", "160x120", "--view", "front")
    assert (done.returncode, done.stderr) == (0, "")
    picture = np.asarray(Image.open(tmp_path / "face.png"))
    assert picture.shape == (120, 160, 3)
    assert is_face(picture).mean() > 0.2


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--set", "AU12"), "not NAME=WEIGHT"),
        (("--set", "AU12=much"), "not NAME=WEIGHT"),
        (("--set", "AU12=1.5"), "out of range"),
        (("--set", "AU12=nan"), "out of range"),
        (("--set", "AU99=0.5"), "not known to this model"),
        (("--set", "AU12=0.5", "--set", "AU12=0.6"), "set twice"),
        (("--size", "900"), "not WIDTHxHEIGHT"),
        (("--size", "9x900"), "16 to 8192"),
        (("--view", "top"), "choose from"),
    ],
)
def test_render_command_tells_bad_options_in_one_line(
    model_file: Path, tmp_path: Path, options: tuple[str, ...], message: str
) -> None:
    done = render(model_file, tmp_path / "face.png", *options)
    assert done.returncode == 2
    assert message in done.stderr
    assert done.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("output", ["face.jpg", "absent/face.png"])
def test_render_command_refuses_a_place_it_cannot_write(model_file: Path, tmp_path: Path, output: str) -> None:
    done = render(model_file, tmp_path / output, "--size", "160x120")
    assert done.returncode == 2
    assert output in done.stderr


@pytest.mark.skipif(ctypes.util.find_library("OSMesa") is not None, reason="OSMesa draws where EGL cannot")
def test_render_command_says_so_where_nothing_can_draw(model_file: Path, tmp_path: Path) -> None:
    command = [*RISORIUS, "render", str(model_file), "-o", str(tmp_path / "face.png")]
    bare = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    without_egl = bare | {"__EGL_VENDOR_LIBRARY_DIRS": str(tmp_path)}
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, env=without_egl)
    assert done.returncode == 1
    assert "no OpenGL" in done.stderr.splitlines()[-1]
