"""Choices of elements that cost accuracy are told, with their measured error and the remedy."""

import pytest
import typer
from typer.testing import CliRunner

from risorius.mechanics.material import Yeoh
from risorius_offline.commands import register
from risorius_offline.elements.advice import advice
from tests.offline.meshes import box
from tests.offline.models import block_anatomy, muscle_block


def test_linear_tetrahedra_in_nearly_incompressible_tissue_are_told_with_the_measured_error():
    (line,) = advice(muscle_block("tetra", Yeoh.neo_hookean(15e3, 0.485)))
    assert line.startswith("block: 48 linear tetrahedra with Poisson's ratio up to 0.485")
    assert "at 0.49 a layered cheek comes out 20 % wrong, and 1.8 % with as many nodes in quadratic" in line
    assert line.endswith("export the mesh as tetra10")


@pytest.mark.parametrize(
    ("cell_type", "poisson"), [("tetra", 0.45), ("tetra10", 0.499), ("hexahedron", 0.499), ("wedge", 0.499)]
)
def test_nothing_is_said_about_other_choices(cell_type, poisson):
    assert advice(muscle_block(cell_type, Yeoh.neo_hookean(15e3, poisson))) == ()


def test_command_line_says_it_once_and_goes_on(tmp_path):
    muscle_block("tetra", Yeoh.neo_hookean(15e3, 0.49)).save(tmp_path / "draft.h5")
    app = typer.Typer()
    register(app)
    done = CliRunner().invoke(app, ["anatomy", str(tmp_path / "draft.h5"), "-o", str(tmp_path / "face.h5")])
    assert done.exit_code == 0
    assert done.stderr.count("warning: ") == done.stderr.count("\n") == 1
    assert "48 linear tetrahedra" in done.stderr
    assert (tmp_path / "face.h5").exists()


def test_cells_that_are_inverted_where_no_quadrature_point_sees_it_are_told():
    points, cells = box("hexahedron", (1, 1, 1), (0.02,) * 3)
    points[-1, 2] = -0.011
    (line,) = advice(block_anatomy(points, cells, Yeoh.neo_hookean(15e3, 0.45)))
    assert line.startswith("block: 1 cell(s) are inverted somewhere between their quadrature points at rest")
    assert line.endswith("move their nodes")
