"""Options of the commands that solve snapshots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import typer

from risorius_offline.contact_choice import ContactChoice

DEFAULT_COUNT, DEFAULT_HELD_OUT = 120, 24

Count = Annotated[int, typer.Option("--snapshots", min=1, help="Training snapshots; all single actions are added.")]
HeldOut = Annotated[int, typer.Option(min=1, help="Snapshots to measure accuracy on; never trained with.")]
Seed = Annotated[int, typer.Option(min=0, help="Seed of the sampling design.")]
Adaptive = Annotated[
    bool, typer.Option("--adaptive", help="Choose the second half where the reduced model so far is worst.")
]
TargetError = Annotated[
    float, typer.Option(min=0.0, help="With --adaptive: stop at this held-out error (95 %), millimetres.")
]
Derivatives = Annotated[
    bool, typer.Option("--derivatives/--no-derivatives", help="Keep du/da of each: some 25 times the disk.")
]
Workers = Annotated[int, typer.Option(min=0, help="Processes on this machine; 0 takes one per core.")]
Scheduler = Annotated[
    str | None, typer.Option(metavar="tcp://HOST:PORT", help="Dask scheduler of a running cluster, in their place.")
]
Resume = Annotated[
    bool,
    typer.Option("--resume", help="Go on with OUTPUT as it was asked for, whatever other options say."),
]
Json = Annotated[bool, typer.Option("--json", help="Progress and result as lines of JSON on standard output.")]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Solve one snapshot, and tell what all would take.")]


@dataclass(frozen=True)
class RunOptions:
    """What snapshots are asked for; a file remembers it.

    target_error: millimetres, 0 for none. The last three are effects of the full model.
    """

    count: int
    held_out: int
    seed: int
    adaptive: bool
    target_error: float
    derivatives: bool
    contact: ContactChoice
    prestress: float
    force_length: bool
