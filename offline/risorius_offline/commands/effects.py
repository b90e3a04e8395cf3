"""Options of the commands that solve the full model: which effects it has."""

from __future__ import annotations

from typing import Annotated

import typer

Contact = Annotated[
    bool, typer.Option("--contact/--no-contact", help="Lips and cheeks slide on teeth, bones and each other.")
]
Prestress = Annotated[float, typer.Option(help="Tension of the skin at rest, pascals; living skin has 7e3 to 53e3.")]
ForceLength = Annotated[bool, typer.Option("--force-length", help="Muscles after Hill's force-length curve.")]
Gravity = Annotated[
    tuple[float, float, float] | None,
    typer.Option(metavar="X Y Z", help="m/s2, y up, z out of the face; the shape is that of an upright head."),
]
