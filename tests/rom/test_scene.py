from pathlib import Path

import pytest

from risorius import Budget, FileFormatError, InputError, Scene
from risorius.facs import ACTION_UNITS
from risorius.poses import POSE_LOWER


def test_a_scene_survives_its_file(tmp_path):
    scene = Scene(
        nonlinear=False,
        inputs=("AU12", "jaw_open"),
        region=(3, 4, 5),
        resolution="carriers",
        outputs=("vertices", "normals"),
        budget=Budget(time=2e-4),
    )
    scene.save(tmp_path / "scene.yaml")
    assert Scene.load(tmp_path / "scene.yaml") == scene


def test_a_scene_of_everything_is_an_empty_file(tmp_path):
    Scene().save(tmp_path / "scene.yaml")
    assert (tmp_path / "scene.yaml").read_text() == "{}\n"
    assert Scene.load(tmp_path / "scene.yaml") == Scene()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("inputs: [AU12", "not YAML"),
        ("- AU12", "holds a list"),
        ("colour: red", "field 'colour' is not known; a scene has nonlinear, jaw"),
        ("nonlinear: 3", "nonlinear: 3: "),
        ("region: nose", "region: 'nose': input should be 'full', 'mouth', 'eyes' or 'brows'"),
        ("outputs: [vertices, stress]", "outputs: 'stress': input should be 'vertices', 'normals', 'strain' or"),
        ("budget: {time: -1}", "budget: -1 given; give a positive time"),
    ],
)
def test_a_file_that_is_no_scene_is_refused_by_field(tmp_path, text, message):
    path = tmp_path / "scene.yaml"
    path.write_text(text)
    with pytest.raises(InputError) as raised:
        Scene.load(path)
    assert str(raised.value).startswith(f"{path}: {message}")
    assert isinstance(raised.value, FileFormatError) == ("YAML" in message)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"none\.yaml: no such file"):
        Scene.load(tmp_path / "none.yaml")


EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.yaml"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_scenes_ask_for_inputs_that_there_are(path):
    muscles = {name for unit in ACTION_UNITS.values() for name in unit.muscles}
    known = {*ACTION_UNITS, *POSE_LOWER, *(f"{name}_{side}" for name in muscles for side in "LR")}
    assert set(Scene.load(path).inputs) <= known


def test_there_are_examples():
    assert [path.stem for path in EXAMPLES] == ["animatronic_mouth", "clinical_smile", "telepresence_head"]
