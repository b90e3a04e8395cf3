"""`risorius solve` from the command line to its files."""

from functools import partial

import meshio
import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from risorius.errors import InputError
from risorius_offline import commands
from risorius_offline.equilibrium import EquilibriumSolver, NotConvergedError

app = typer.Typer()
commands.register(app)


def run(*arguments):
    return CliRunner().invoke(app, ["solve", *map(str, arguments)])


@pytest.mark.parametrize("option", ["--set", "--muscle"])
def test_solve_writes_tissue_and_skin_and_tells_the_quantities(option, tmp_path):
    done = run("cylinders", option, "axial=0.2", "-o", tmp_path / "a.vtu")
    assert done.exit_code == 0, done.output
    for text in ("Newton iterations", "smallest J", "largest displacement", "skin strain", "force N", "axial"):
        assert text in done.output
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.skin.vtu", "a.vtu"]
    tissue, skin = meshio.read(tmp_path / "a.vtu"), meshio.read(tmp_path / "a.skin.vtu")
    moved = tissue.point_data["displacement_m"]
    assert moved[tissue.points[:, 1].argmax(), 1] < -1e-3  # the muscle shortens: the free top comes down
    assert np.abs(skin.cell_data["strain_1"][0]).max() > 0.01
    assert tissue.cell_data["active_stress_Pa"][0].max() == pytest.approx(0.2 * 20e3)


def test_rest_has_no_active_muscles_to_tell_of(tmp_path):
    done = run("cylinders", "-o", tmp_path / "a.vtu")
    assert done.exit_code == 0, done.output
    assert "active muscles" not in done.output
    assert not meshio.read(tmp_path / "a.vtu").point_data["displacement_m"].any()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["cylinders", "-o", "a.vtk"], r"a\.vtk: the tissue is written as VTU"),
        (["cylinders", "-o", "nowhere/a.vtu"], r"the folder .*nowhere does not exist"),
        (["cylinders", "-o", "a.vtu", "--set", "axial"], r"not NAME=WEIGHT"),
        (["cylinders", "-o", "a.vtu", "--set", "AU99=1"], r"'AU99' is not known"),
        (["cylinders", "-o", "a.vtu", "--set", "axial=2"], r"axial: weight 2 is out of range"),
        (["nothing", "-o", "a.vtu"], r"nothing: no such file or folder"),
    ],
)
def test_bad_arguments_are_refused_before_anything_is_written(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    error = run(*arguments).exception
    assert isinstance(error, InputError)
    assert error.exit_code == 2
    with pytest.raises(InputError, match=message):
        raise error
    assert not list(tmp_path.iterdir())


def test_no_equilibrium_ends_with_the_solvers_message_and_no_file(tmp_path, monkeypatch):
    monkeypatch.setattr(
        "risorius_offline.equilibrium.EquilibriumSolver",
        partial(EquilibriumSolver, max_iterations=1, smallest_step=0.4),
    )
    error = run("cylinders", "--set", "axial=1", "-o", tmp_path / "a.vtu").exception
    assert isinstance(error, NotConvergedError)
    assert error.exit_code == 1
    assert "axial = 1" in str(error)
    assert not list(tmp_path.iterdir())
