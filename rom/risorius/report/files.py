"""The report as files in a folder; each appears under its name only when it is complete."""

from __future__ import annotations

from pathlib import Path

from risorius.errors import InputError
from risorius.report.page import page
from risorius.report.plot import DARK, LIGHT, draw
from risorius.report.results import Results
from risorius.report.table import as_csv, as_json
from risorius.storage import replaced_when_complete, require_folder_of


def require_folder(folder: Path) -> None:
    """Raise InputError for an output that cannot become a folder of files: better before the work than after it."""
    require_folder_of(folder)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: is a file; give a folder for the report with --output")


def write(results: Results, folder: Path) -> None:
    """Write accuracy.csv, accuracy.json, accuracy.svg, accuracy.png and index.html into a folder, made if need be."""
    light, dark = draw(results, LIGHT, "svg"), draw(results, DARK, "svg")
    files = {
        "accuracy.csv": as_csv(results).encode(),
        "accuracy.json": as_json(results).encode(),
        "accuracy.svg": light,
        "accuracy.png": draw(results, LIGHT, "png"),
        "index.html": page(results, light, dark).encode(),
    }
    require_folder(folder)
    folder.mkdir(exist_ok=True)
    for name, content in files.items():
        with replaced_when_complete(folder / name) as partial:
            partial.write_bytes(content)
