"""What a scene costs and is worth, and which is enough; clocks are not asked."""

from dataclasses import replace

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from risorius import Budget, Engine, InputError, Scene, commands, suggesting
from risorius.effects import EFFECTS
from risorius.report.effects import prices
from risorius.suggesting import suggest
from risorius.timeline import Timeline

SMILE = "AU12,jaw_open,AU26\n0,0,0\n0.5,0,0.001\n1,0,0\n"


@pytest.fixture
def app():
    app = typer.Typer()
    commands.register(app)
    return app


@pytest.fixture
def smile(tmp_path, synthetic_model):
    (tmp_path / "smile.csv").write_text(SMILE)
    return Timeline.read(tmp_path / "smile.csv", synthetic_model.inputs)


@pytest.fixture
def counted(monkeypatch):
    """In place of the clock: inputs, and ten more where muscles interact."""

    def cost(run):
        return len(run.engine.inputs) + 10 * run.scene.nonlinear

    monkeypatch.setattr(suggesting, "frame_times", lambda runs: np.array([[cost(run)] for run in runs]))


def gap(model, first, second, weights):
    return np.linalg.norm(Engine(model, first).evaluate(weights).vertices
                          - Engine(model, second).evaluate(weights).vertices, axis=1)  # fmt: skip


def test_the_worth_of_interaction_is_how_far_superposition_is_off(synthetic_model, smile):
    rows = {row.change: row for row in prices(synthetic_model, Scene(outputs=("normals",)), smile).rows}
    off = gap(synthetic_model, Scene(), Scene(nonlinear=False), {"AU12": 1.0})
    assert rows["without nonlinear"].maximum == pytest.approx(off.max(), rel=1e-3)
    assert set(rows) == {"the same", "without nonlinear", "without jaw", "without normals"}
    assert rows["the same"].maximum == rows["without normals"].maximum == 0.0


def test_a_budget_does_not_make_a_scene_differ_from_itself(synthetic_model, smile):
    found = prices(synthetic_model, Scene(budget=Budget(time=1e-9)), smile)
    assert {row.change: row.maximum for row in found.rows}["without nonlinear"] > 0.0


def test_restrictions_are_priced_against_the_whole(synthetic_model, smile):
    found = prices(synthetic_model, Scene(inputs=("AU12",), region=tuple(range(50)), resolution="carriers"), smile)
    assert {"with all inputs", "with the whole face", "with every vertex"} <= {row.change for row in found.rows}


@pytest.mark.usefixtures("counted")
def test_the_cheapest_scene_within_the_error_is_suggested(synthetic_model, smile):
    exact = suggest(synthetic_model, smile, most=2e-5)
    assert exact.scene == Scene(inputs=("AU12", "AU26"))
    rough = suggest(synthetic_model, smile, most=5e-3)
    assert rough.scene == Scene(inputs=("AU12",), nonlinear=False)
    assert exact.error <= 2e-5 < rough.error <= 5e-3


@pytest.mark.usefixtures("counted")
def test_what_the_base_leaves_out_stays_out(synthetic_model, smile):
    base = Scene(inputs=("AU12_L", "AU12_R"), region=tuple(range(80)))
    assert suggest(synthetic_model, smile, 2e-5, base).scene == base.model_copy(update={"inputs": ("AU12",)})


def test_no_error_and_no_motion_are_refused(synthetic_model, smile):
    with pytest.raises(InputError, match="largest error 0; give a positive length"):
        suggest(synthetic_model, smile, most=0.0)
    still = replace(smile, name="still", weights=0.0 * smile.weights)
    with pytest.raises(InputError, match="still: moves no input of the scene"):
        suggest(synthetic_model, still, most=1e-3)


def test_the_commands_print_scenes_that_load(app, model_file, tmp_path, smile):
    shown = CliRunner().invoke(app, ["scene", "show", str(model_file)])
    (tmp_path / "shown.yaml").write_text(shown.output)
    assert Scene.load(tmp_path / "shown.yaml") == Scene(jaw=True, **dict.fromkeys(EFFECTS, False))
    assert "# vertices: 320 of 320" in shown.output
    written = tmp_path / "smile.yaml"
    arguments = ["scene", "suggest", str(tmp_path / "smile.csv"), str(model_file), "--max-error", "0.02"]
    found = CliRunner().invoke(app, [*arguments, "-o", str(written)])
    assert Scene.load(written).inputs == ("AU12", "AU26")
    assert "over 3 frames of smile.csv" in found.output


def test_the_report_of_effects_is_written(app, model_file, tmp_path, smile):
    scene, out = tmp_path / "scene.yaml", tmp_path / "report"
    Scene(inputs=("AU12",)).save(scene)
    arguments = ["report", str(model_file), "--scene", str(scene), "-o", str(out)]
    found = CliRunner().invoke(app, [*arguments, "--timeline", str(tmp_path / "smile.csv")])
    assert found.exit_code == 0
    lines = (out / "effects.csv").read_text().splitlines()
    assert [line.split(",")[0] for line in lines] == [
        "change", "the same", "without nonlinear", "with all inputs"
    ]  # fmt: skip
    refused = CliRunner().invoke(app, ["report", str(model_file), "--timeline", str(scene)]).exception
    assert isinstance(refused, InputError)
