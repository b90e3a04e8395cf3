"""SOURCE of the command line: a built-in anatomy, a folder in the import format, or an anatomy file."""

from __future__ import annotations

from pathlib import Path

from risorius.errors import InputError
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.anatomy.folder import import_folder
from risorius_offline.anatomy.nested_cylinders import nested_cylinders
from risorius_offline.source_names import CYLINDERS, HEADS


def load_source(source: str) -> Anatomy:
    """Anatomy of a source; raises InputError."""
    if source in HEADS:
        from risorius_offline.head import built_in_head

        return built_in_head(HEADS[source])
    if source == CYLINDERS:
        return nested_cylinders()
    path = Path(source)
    if path.is_dir():
        return import_folder(path)
    if path.is_file():
        return Anatomy.load(path)
    raise InputError(
        f"{source}: no such file or folder; give {', '.join(HEADS)} or {CYLINDERS}, an import folder or an anatomy file"
    )
