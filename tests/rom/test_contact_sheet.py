"""Contact sheets: what is on them and how they are put together."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pyvista", reason="the extra `view` is not installed")
from PIL import Image
from tests.full_head import HEAD
from tests.rom.test_picture import RISORIUS

from risorius import Engine, ReducedModel
from risorius.contact_sheet import VIEWS, draw_sheet
from risorius.facs import ACTION_UNITS
from risorius.inputs import InputTable
from risorius.picture import draw_faces
from risorius.sheets import SHEETS, Face, faces_of

SIZE = (60, 140)


def labels(sheet: str, table: InputTable = HEAD) -> list[str]:
    return [face.label for face in faces_of(sheet, table)]


@pytest.mark.parametrize("sheet", SHEETS)
def test_every_sheet_begins_with_the_neutral_face_and_has_only_admissible_ones(sheet: str) -> None:
    faces = faces_of(sheet, HEAD)
    assert faces[0] == Face("neutral")
    for face in faces[1:]:
        parameters = HEAD.to_parameters(HEAD.weights(face.weights), face.muscles)
        assert np.abs(parameters).max() > 0.0


def test_units_are_all_of_facs_by_number_and_name() -> None:
    assert labels("units")[1:] == [f"{name}  {unit.name}" for name, unit in ACTION_UNITS.items()]


def test_expressions_are_the_six_emotions_and_two_figures_and_say_what_a_model_lacks() -> None:
    six = ["happiness", "surprise", "sadness", "anger", "fear", "disgust"]
    assert labels("expressions")[1:] == [*six, "happiness of Figure 7.17", "disgust of Figure 7.18"]
    smiling = InputTable(("zygomaticus_major_L", "zygomaticus_major_R"))
    assert labels("expressions", smiling)[1:] == ["happiness, without AU6", "happiness of Figure 7.17"]


def test_jaw_moves_as_in_figure_7_12_to_the_persons_own_sides() -> None:
    faces = faces_of("jaw", HEAD)[1:]
    assert [face.label for face in faces] == ["jaw forward", "jaw right", "jaw down", "jaw left"]
    assert [dict(face.weights) for face in faces][1] == {"jaw_sideways": -1.0}


def test_muscles_of_the_figures_come_first_and_all_others_once() -> None:
    shown = labels("muscles")[1:]
    assert shown[:4] == ["zygomaticus major L", "depressor anguli oris R", "levator labii superioris R", "mentalis L"]
    others = [name.replace("_", " ") for name in HEAD.muscles if name.endswith("_L")]
    assert sorted(shown) == sorted({*others, *shown[:4]})


@pytest.fixture(scope="module")
def engine(synthetic_model: ReducedModel) -> Engine:
    return Engine(synthetic_model)


def test_sheet_shows_each_face_from_both_views_with_a_label_beneath(engine: Engine) -> None:
    faces = [Face("neutral"), Face("jaw down", {"jaw_open": 1.0})]
    sheet = draw_sheet(engine, faces, SIZE)
    strip = sheet.shape[0] - SIZE[1]
    assert sheet.shape == (SIZE[1] + strip, 2 * len(VIEWS) * SIZE[0], 3)
    drawn = [engine.evaluate(face.weights).vertices for face in faces]
    pictures = draw_faces(drawn, engine.triangles, views=VIEWS, size=SIZE)
    np.testing.assert_array_equal(sheet[: SIZE[1]], np.concatenate([p for row in pictures for p in row], axis=1))
    written = sheet[SIZE[1] :].min(axis=(0, 2)) < 100  # dark ink in both labels, and none at their borders
    assert written[:120].any()
    assert written[120:].any()
    assert not written[[0, 119, 120, -1]].any()


def test_rows_are_as_even_as_can_be_and_padded_with_paper(engine: Engine) -> None:
    seven = draw_sheet(engine, [Face(str(number)) for number in range(7)], SIZE)
    assert seven.shape[1] == 4 * len(VIEWS) * SIZE[0]
    empty = seven[seven.shape[0] // 2 :, 3 * len(VIEWS) * SIZE[0] :]
    assert (empty == empty[0, 0]).all()


def test_faces_of_a_sheet_share_the_camera_and_room_for_all(engine: Engine) -> None:
    still = engine.model.rest_vertices
    alone = draw_faces([still], engine.triangles, views=["front"], size=SIZE)[0][0]
    larger = draw_faces([still, 2.0 * still], engine.triangles, views=["front"], size=SIZE)[0][0]
    skin = [(picture[..., 0].astype(int) > picture[..., 2].astype(int) + 15).sum() for picture in (alone, larger)]
    assert skin[1] / skin[0] == pytest.approx(0.25, abs=0.05)


def test_render_command_writes_a_sheet(model_file: Path, tmp_path: Path) -> None:
    command = [*RISORIUS, "render", str(model_file), "-o", str(tmp_path / "jaw.png"), "--sheet", "jaw"]
    done = subprocess.run([*command, "--size", "60x80"], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")
    assert "5 faces" in done.stdout
    width, height = Image.open(tmp_path / "jaw.png").size
    assert width == 5 * 2 * 60
    assert 80 < height < 2 * 80  # five faces take one row


@pytest.mark.parametrize(
    ("options", "message"),
    [(("--sheet", "hands"), "choose from: units, expressions"), (("--sheet", "jaw", "--view", "side"), "leave --set")],
)
def test_render_command_refuses_what_no_sheet_has(
    model_file: Path, tmp_path: Path, options: tuple[str, ...], message: str
) -> None:
    command = [*RISORIUS, "render", str(model_file), "-o", str(tmp_path / "sheet.png"), *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 2
    assert message in done.stderr
    assert not list(tmp_path.iterdir())
