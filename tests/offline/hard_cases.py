"""The hard cases of the full model as data, and the table of all of them.

`python -m tests.offline.hard_cases -o docs/hard_cases.md` solves them all and writes the table.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

from risorius.inputs import InputTable, without_side
from risorius.jaw import FloatArray
from risorius.mechanics.fibres import HILL
from risorius_offline.anatomy import Anatomy, load_source
from risorius_offline.contact_choice import ContactChoice
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.effects.bone_contact import BoneContact
from risorius_offline.effects.lip_contact import LipContact
from tests.offline.hard_attempts import REFUSED, HardCase
from tests.offline.hard_cheek import cheek_cases
from tests.offline.hard_models import (
    ACROSS,
    ALONG,
    DENSITY,
    LEFT,
    MUSCLES,
    RIGHT,
    RING,
    SHEET,
    YOUNGS,
    block_over_bone,
    column,
    crushed_block,
    dragging,
    piston,
    slab,
    turning,
    two_blocks,
)
from tests.offline.hard_mouth import mouth_cases
from tests.offline.hard_setup import AT_ONCE, accelerated, at, case, driven, every_muscle, tense
from tests.offline.hard_table import document, row
from tests.published_face import published_face_folder

CELL_TYPES = ("hexahedron", "wedge", "tetra", "tetra10")


def element_cases() -> list[HardCase]:
    """What every element type has to bear."""
    cases = []
    for kind in CELL_TYPES:
        for name, muscles in MUSCLES.items():
            cases.append(case(f"{kind}: {name} at 1", partial(slab, kind, muscles), every_muscle(1.0)))
        for poisson in (0.45, 0.49, 0.499, 0.4999):
            anatomy = partial(slab, kind, (LEFT, RIGHT, ACROSS), poisson=poisson)
            cases.append(case(f"{kind}: Poisson's ratio {poisson:g}, three muscles at 1", anatomy, every_muscle(1.0)))
        cases.append(case(f"{kind}: fibre sheet of 300 kPa", partial(slab, kind, (SHEET,)), at(1.0)))
        crushed = partial(crushed_block, kind)
        cases.append(case(f"{kind}: sliver, muscle at 1", crushed, at(1.0, 0.0, 0.0, 0.0)))
        turned = partial(column, kind, turning(45.0))
        cases.append(case(f"{kind}: end turned by 45 degrees", turned, at(1.0, 0.0, 0.0)))
    return cases


def layer_cases() -> list[HardCase]:
    """Layers of very different stiffness, and thin ones."""
    deep, muscle, fat, skin = YOUNGS
    ratios = {
        "skin 1000 times stiffer than fat": (deep, muscle, fat, 1000 * fat),
        "fat 1000 times stiffer than skin": (deep, muscle, 1000 * skin, skin),
        "every second layer 1000 times stiffer": (1e6, 1e3, 1e6, 1e3),
    }
    cases = []
    for kind in ("hexahedron", "wedge"):
        for name, youngs in ratios.items():
            cases.append(case(f"{kind}: {name}", partial(slab, kind, youngs=youngs), at(1.0)))
        for thickness in (5e-4, 1e-4):
            anatomy = partial(slab, kind, skin=thickness, epidermis=1e-4)
            cases.append(case(f"{kind}: skin of {1e3 * thickness:g} mm", anatomy, at(1.0)))
    return cases


def path_cases() -> list[HardCase]:
    """Activation without continuation, back to rest, and out of the usual range."""
    fibres = {"one muscle": (ALONG,), "fibre sheet of 300 kPa": (SHEET,), "sphincter": (RING,)}
    cases = []
    for name, muscles in fibres.items():
        anatomy = partial(slab, muscles=muscles)
        cases.append(case(f"{name}: 0 to 1 in one step", anatomy, at(1.0), settings=AT_ONCE))
        cases.append(case(f"{name}: 1 to 0 in one step", anatomy, at(0.0), settings=AT_ONCE, start=at(1.0)))
    for activation in (5e-324, 1e-300, -0.0, 1e-12, 1.3):
        cases.append(case(f"activation {activation:g}", slab, at(activation)))
    for name, muscles in {**MUSCLES, **fibres}.items():
        cases.append(case(f"Hill's law: {name} at 1", partial(slab, muscles=muscles), every_muscle(1.0), law=HILL))
    return cases


def load_cases() -> list[HardCase]:
    """Gravity, pre-stress and force densities."""
    density = partial(slab, muscles=(DENSITY,))
    both = (accelerated(0.0, 0.0, -98.1), tense(50e3))
    return [
        case("10 g into the bone", slab, at(0.0), accelerated(0.0, 0.0, -98.1)),
        case("10 g away from the bone", slab, at(0.0), accelerated(0.0, 0.0, 98.1)),
        case("10 g sideways, muscle at 1", slab, at(1.0), accelerated(98.1, 0.0, 0.0)),
        case("pre-stress of 50 kPa, muscle at 1", slab, at(1.0), tense(50e3)),
        case("pre-stress of 50 kPa, fibre sheet of 300 kPa", partial(slab, muscles=(SHEET,)), at(1.0), tense(50e3)),
        case("10 g, pre-stress of 50 kPa, muscle at 1", slab, at(1.0), *both),
        case("force density at 1", density, at(1.0)),
        case("force density at its double", density, at(2.0)),
        case("force density at its double in one step", density, at(2.0), settings=AT_ONCE),
    ]


def bone_cases() -> list[HardCase]:
    """Bones that drag tissue along, and contact in one step."""
    sideways, forward = at(0.0, 0.0, 1.0), at(0.0, 1.0, 0.0)
    cases = [
        case(f"{kind}: end dragged sideways by {1e3 * way:g} mm", partial(column, kind, dragging(way)), sideways)
        for kind in ("hexahedron", "tetra10")
        for way in (0.008, 0.015, 0.03)
    ]
    for way in (0.03, -0.008):
        verb = "stretched" if way > 0 else "squeezed"
        anatomy = partial(column, "hexahedron", dragging(along=way))
        cases.append(case(f"{verb} by {1e3 * abs(way):g} mm", anatomy, forward))
    for kind in ("hexahedron", "tetra"):
        anatomy = partial(crushed_block, kind, dragged=0.015)
        cases.append(case(f"{kind}: sliver, dragged by 15 mm, muscle at 1", anatomy, at(1.0, 0.0, 0.0, 1.0)))
    for down in (0.002, 0.005):
        anatomy = partial(block_over_bone, down)
        cases.append(case(f"block pressed {1e3 * down:g} mm down on a bone", anatomy, forward, BoneContact))
        anatomy = partial(two_blocks, down)
        cases.append(case(f"blocks pressed together by {1e3 * down:g} mm", anatomy, forward, LipContact))
    return cases


def refused_cases() -> list[HardCase]:
    """What has no answer, or none within what is allowed."""
    moved = partial(piston, "hexahedron", dragging(along=-0.004))
    through = partial(column, "hexahedron", dragging(along=-0.08))
    sheet = partial(slab, muscles=(SHEET,))
    hasty = {**AT_ONCE, "max_iterations": 3}
    cases = [
        case("jaw 10 times out of range: 40 mm into a confined block of 30 mm", moved, at(0.0, 10.0, 0.0)),
        case("column of 30 mm with free sides, end pushed 80 mm through its base", through, at(0.0, 1.0, 0.0)),
        case("one iteration a step", slab, at(1.0), settings={"max_iterations": 1}),
        case("fibre sheet of 300 kPa in one step of three iterations", sheet, at(1.0), settings=hasty),
    ]
    return [replace(one, expect=REFUSED) for one in cases]


SMALL_CASES = (
    *element_cases(),
    *layer_cases(),
    *path_cases(),
    *load_cases(),
    *bone_cases(),
    *cheek_cases(),
    *mouth_cases(),
    *refused_cases(),
)


@cache
def face_anatomy() -> Anatomy:
    """The published face, read once."""
    return load_source(str(published_face_folder()))


def face_cases() -> tuple[HardCase, ...]:
    """Extreme inputs of the published face."""
    antagonists = {"zygomaticus_major": 1.0, "depressor_anguli_oris": 1.0}
    sealed = {"orbicularis_oris_peripheralis": 1.0}
    return (
        case("face: every muscle at 0.5", face_anatomy, every_muscle(0.5)),
        case("face: every muscle at 1", face_anatomy, every_muscle(1.0)),
        case("face: zygomaticus against depressor, at 1", face_anatomy, driven(antagonists)),
        case("face: jaw_open 1", face_anatomy, driven(jaw_open=1.0)),
        case("face: jaw_open 1, orbicularis oris at 1", face_anatomy, driven(sealed, jaw_open=1.0)),
        case("face: AU9 + AU18 + AU23 at 1", face_anatomy, driven(AU9=1.0, AU18=1.0, AU23=1.0)),
    )


def action_unit_cases() -> tuple[HardCase, ...]:
    """Every action unit of the published face, fully, against its bones."""
    units = dict.fromkeys(without_side(name) for name in face_anatomy().inputs.names if name.startswith("AU"))
    title = "face, bone contact: {} at 1"
    return tuple(case(title.format(unit), face_anatomy, driven(**{unit: 1.0}), BoneContact) for unit in units)


@cache
def head_anatomy() -> Anatomy:
    """The draft of the built-in head, built once."""
    return load_source("builtin-draft")


def head_cases() -> tuple[HardCase, ...]:
    """Every action unit of the built-in head, fully, with the contact that it is trained with."""
    units = dict.fromkeys(without_side(name) for name in head_anatomy().inputs.names if name.startswith("AU"))
    build = partial(EffectChoice(ContactChoice.LIPS).model, head_anatomy())
    title = "head, contact with bones and of lips: {} at 1"
    return tuple(HardCase(title.format(unit), build, driven(**{unit: 1.0})) for unit in units)


def face_contact_cases() -> tuple[HardCase, ...]:
    """Lips, cheeks and bones of the published face in contact, under all that there is."""
    closed, opened = driven(AU18=1.0), driven(AU18=1.0, AU26=1.0)
    both = (BoneContact, LipContact)
    return (
        case("face, both contacts: every muscle at 1", face_anatomy, every_muscle(1.0), *both),
        case("face, both contacts: every muscle at 1, jaw_open 1", face_anatomy, every_muscle_and_jaw, *both),
        case("face, both contacts: jaw closes from AU26 on AU18 at 1", face_anatomy, closed, *both, start=opened),
    )


def every_muscle_and_jaw(inputs: InputTable) -> FloatArray:
    return every_muscle(1.0)(inputs) + driven(jaw_open=1.0)(inputs)


def main() -> None:
    """Solve all cases and write their table, anew after each group."""
    parser = argparse.ArgumentParser(description="Solve the hard cases and write their table.")
    parser.add_argument("-o", "--output", type=Path, required=True)
    output = parser.parse_args().output
    groups: list[Callable[[], tuple[HardCase, ...]]] = [lambda: SMALL_CASES, head_cases]
    groups += [face_cases, action_unit_cases, face_contact_cases] if published_face_folder().is_dir() else []
    rows = []
    for group in groups:
        for one in group():
            rows.append(row(one))
            print(rows[-1].text, flush=True)
        output.write_text(document(rows), encoding="utf-8")


if __name__ == "__main__":
    main()
