import pytest

from risorius import Budget, FileFormatError, InputError, Scene


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
