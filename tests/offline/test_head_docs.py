"""docs/head.md keeps step with the muscles and norms of the built-in head."""

from pathlib import Path

import pytest

from risorius.facs import ACTION_UNITS
from risorius_offline.head.muscles import COURSES
from risorius_offline.head.proportions import NORMS

PAGE = Path(__file__).parents[2] / "docs" / "head.md"


def units_of(muscle):
    """Numbers of the action units that have a muscle, as the table gives them."""
    return ", ".join(str(unit.number) for unit in ACTION_UNITS.values() if muscle in {**unit.muscles, **unit.helpers})


def rows():
    """Cells of each row of a table by its first cell, without the backquotes."""
    lines = [line for line in PAGE.read_text().splitlines() if line.startswith("| `")]
    return {cells[0].strip("`"): cells[1:] for cells in ([c.strip() for c in line[1:-1].split("|")] for line in lines)}


def test_page_has_every_muscle_with_its_units_radius_and_stress():
    found = rows()
    for course in COURSES:
        units, _, _, radius, stress = found[course.name]
        assert units == units_of(course.name), course.name
        assert float(radius) == course.radius, course.name
        assert float(stress) == pytest.approx(1e-3 * course.stress), course.name


def test_page_has_every_norm_with_its_deviation():
    found = rows()
    for name, (mean, deviation) in NORMS.items():
        assert [float(cell) for cell in found[name][:2]] == [round(1e3 * mean, 6), round(1e3 * deviation, 6)], name
