"""`risorius solve`: one equilibrium of the full model, with what people ask of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from risorius.commands.settings import parse_settings, split_muscles
from risorius.errors import InputError
from risorius.storage import require_folder_of
from risorius_offline.commands.effects import Contact, ForceLength, Gravity, Prestress, contact_of
from risorius_offline.commands.installed import require_offline
from risorius_offline.commands.source import load
from risorius_offline.source_names import SOURCE_HELP

if TYPE_CHECKING:
    from rich.table import Table

    from risorius_offline.equilibrium import Equilibrium
    from risorius_offline.full_model import FullModel
    from risorius_offline.quantities import SkinState


def solve(
    source: Annotated[str, typer.Argument(help=SOURCE_HELP)],
    output: Annotated[Path, typer.Option("--output", "-o", help="File of the tissue to write, .vtu.")],
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set", "--muscle", metavar="NAME=WEIGHT", help="Weight of an input or a muscle; may be given often."
        ),
    ] = None,
    contact: Contact = None,
    gravity: Gravity = None,
    prestress: Prestress = 0.0,
    force_length: ForceLength = False,
) -> None:
    """Solve the full model and write tissue and skin for ParaView, the skin as NAME.skin.vtu beside the tissue."""
    require_offline("risorius solve")
    if output.suffix.lower() != ".vtu":
        raise InputError(f"{output}: the tissue is written as VTU; give a name that ends in .vtu")
    require_folder_of(output)
    values = parse_settings(settings or ())
    from rich.console import Console

    from risorius_offline.effect_choice import EffectChoice
    from risorius_offline.equilibrium import EquilibriumSolver
    from risorius_offline.exporters.vtu import write_skin, write_tissue
    from risorius_offline.quantities import skin_state

    anatomy = load(source)
    inputs, muscles = split_muscles(values, anatomy.inputs)
    parameters = anatomy.inputs.to_parameters(anatomy.inputs.weights(inputs), muscles)
    model = EffectChoice(contact_of(source, contact), gravity, prestress, force_length).model(anatomy)
    found = EquilibriumSolver(model).solve(parameters)
    skin = skin_state(model, found.u)
    skin_output = output.with_suffix(".skin.vtu")
    write_tissue(output, model, found)
    write_skin(skin_output, model, found.u, skin)
    console = Console(soft_wrap=True, highlight=False)
    console.print(_summary(model, found, skin))
    if found.parameters[: model.muscle_count].any():
        console.print(_muscles(model, found))
    console.print(f"{output}, {skin_output}: {anatomy.name}, {len(anatomy.points)} nodes", markup=False)


def _summary(model: FullModel, found: Equilibrium, skin: SkinState) -> Table:
    import numpy as np
    from rich.table import Table

    from risorius_offline.quantities import bone_reactions

    report, reactions = found.report, bone_reactions(model, found)
    rows = {
        "load steps": f"{report.steps}, {report.rejected_steps} rejected",
        "Newton iterations": f"{report.iterations}, {report.factorisations} factorisations",
        "residual": f"{report.residual:.1e}",
        "stable": "yes" if report.stable else "not proven: the energy is flat in some direction",
        "energy, mJ": f"{1e3 * report.energy:.4g}",
        "largest displacement, mm": f"{1e3 * np.linalg.norm(found.u, axis=1).max():.3f}",
        "smallest J": f"{report.smallest_jacobian:.3f}",
        "skin strain, smallest and largest": f"{skin.strains.min():.3f}, {skin.strains.max():.3f}",
        "skin stress, largest principal, kPa": f"{1e-3 * skin.principal_stresses.max():.3g}",
        "reaction of skull, jaw and lids, N": ", ".join(
            f"{np.linalg.norm(force):.3f}" for force in (reactions.skull, reactions.jaw, reactions.lids)
        ),
    }
    table = Table(title="equilibrium", show_header=False)
    for name, value in rows.items():
        table.add_row(name, value)
    return table


def _muscles(model: FullModel, found: Equilibrium) -> Table:
    from rich.table import Table

    from risorius_offline.quantities import muscle_state

    state = muscle_state(model, found)
    table = Table(title="active muscles")
    for column in ("muscle", "activation", "stretch", "force N", "work mJ"):
        table.add_column(column, justify="left" if column == "muscle" else "right")
    for number, muscle in enumerate(model.anatomy.muscles):
        if state.activations[number] > 0.0:
            figures = (state.activations[number], state.stretches[number], state.forces[number])
            table.add_row(muscle.name, *(f"{value:.3g}" for value in figures), f"{1e3 * state.works[number]:.3g}")
    return table
