"""Options of the commands that solve the full model: which effects it has."""

from __future__ import annotations

from typing import Annotated

import typer

from risorius_offline.contact_choice import ContactChoice
from risorius_offline.source_names import HEADS

Contact = Annotated[
    ContactChoice | None,
    typer.Option(
        "--contact",
        help="Lips and cheeks slide on teeth and bones, in full also on each other. By default on the bones of the "
        "built-in head, on nothing elsewhere.",
        show_default=False,
    ),
]
Prestress = Annotated[float, typer.Option(help="Tension of the skin at rest, pascals; living skin has 7e3 to 53e3.")]
ForceLength = Annotated[bool, typer.Option("--force-length", help="Muscles after Hill's force-length curve.")]
Gravity = Annotated[
    tuple[float, float, float] | None,
    typer.Option(metavar="X Y Z", help="m/s2, y up, z out of the face; the shape is that of an upright head."),
]


def contact_of(source: str, asked: ContactChoice | None) -> ContactChoice:
    """Contact as asked for, else on the bones of a built-in head and on nothing elsewhere."""
    if asked is not None:
        return asked
    return ContactChoice.BONES if source in HEADS else ContactChoice.NONE
