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
        help="Lips and cheeks slide on teeth and bones; lips also on each other, or in full all of the surface. By "
        "default as lips on the built-in head, on nothing elsewhere.",
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
    """Contact as asked for, else of lips and bones on a built-in head and of nothing elsewhere."""
    if asked is not None:
        return asked
    return ContactChoice.LIPS if source in HEADS else ContactChoice.NONE
