"""The source of a command, with what there is to say about it."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from risorius_offline.anatomy.anatomy import Anatomy


def load(source: str) -> Anatomy:
    """Anatomy of a source; what its choice of elements costs is told on stderr. Raises InputError."""
    from rich.console import Console

    from risorius_offline.anatomy import load_source
    from risorius_offline.elements.advice import advice

    anatomy = load_source(source)
    for line in advice(anatomy):
        Console(stderr=True, soft_wrap=True, highlight=False).print(f"warning: {line}", markup=False)
    return anatomy
