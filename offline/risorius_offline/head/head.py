"""The built-in head put together: mesh, layers, muscles, what holds it, and what is seen."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice

import numpy as np

from risorius.companion import Companion
from risorius.errors import InputError
from risorius.jaw import FloatArray, JawMotion
from risorius.lids import LidMotion
from risorius.mechanics.material import Yeoh
from risorius.surface import CarriedSurface
from risorius_offline.anatomy.anatomy import Anatomy, Surface
from risorius_offline.anatomy.layers import POISSON, layer_materials
from risorius_offline.discretisation import CellBlock, IntArray
from risorius_offline.head.attachments import Flags, attachments
from risorius_offline.head.bones import bones
from risorius_offline.head.colours import skin_colours
from risorius_offline.head.companions import companions
from risorius_offline.head.muscles import COURSES
from risorius_offline.head.nostrils import with_nostrils
from risorius_offline.head.openings import lid_margins
from risorius_offline.head.proportions import ADULT, Proportions
from risorius_offline.head.reshape import SELLION, reshaped
from risorius_offline.head.sheet import face_sheet, rim
from risorius_offline.head.shell import Shell, layered_shell
from risorius_offline.head.skin import EYE_CENTRE, distance_to_eye
from risorius_offline.head.visible import VisibleSkin, visible_skin
from risorius_offline.muscles.loads import ActiveStress
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.polyline_fibres import PolylineFibres

SIZES = {"draft": 2.1, "standard": 1.2, "fine": 0.7}  # multiples of the edge lengths of `sheet.face_sheet`
METRES = 1e-3
LOOSE, LOOSE_STIFFNESS = 4, 1.0e3  # layer of the loose tissue beneath the chin; Young's modulus, Pa
LID, LID_STIFFNESS, LID_REACH = 5, 2.0e3, 23.0  # layer of the lids, about the eyeball's centre
AREOLAR, AREOLAR_STIFFNESS = 6, 1.0e3  # layer of the loose tissue on which the galea glides
CHIN, THROAT = -76.0, 66.0  # below and behind which deep fat is loose
CONDYLE = np.array([0.0, -2.0, 8.0])
OPENING_ANGLE, OPENING_SLIDE, FORWARD_SLIDE, SIDEWAYS_SLIDE = 0.58, 0.015, 0.005, 0.008
CLOSING_ANGLE = 0.68  # radians from the open lid to the lower one
EPIDERMIS = 1e-4


def built_in_head(size: str = "standard", proportions: Proportions = ADULT) -> Anatomy:
    """Anatomy of the built-in head; raises InputError for an unknown size and for proportions that fold it."""
    return reshaped(sculpted_head(size), proportions)


def sculpted_head(size: str) -> Anatomy:
    """Built-in head as it is sculpted, whose proportions are near those of an adult."""
    if size not in SIZES:
        raise InputError(f"size {size!r} of the built-in head is not known; choose one of {', '.join(SIZES)}")
    sheet = face_sheet(SIZES[size])
    shell = layered_shell(sheet)
    to_rim = np.maximum(-rim(sheet.uv) - 1e-3, 0.0)
    count = shell.level_size
    held = attachments(shell.points[:count], to_rim, lid_margins()[0])
    levels = len(shell.points) // count
    skull, jaw = np.zeros((levels, count), dtype=bool), np.zeros((levels, count), dtype=bool)
    skull[0], jaw[0] = held.skull, held.jaw
    skull[:, held.canthi | (to_rim == 0.0)] = True
    skin = visible_skin(sheet, shell, to_rim == 0.0)
    colours = with_nostrils(skin_colours(skin.points, skin.lining), skin.points)
    return Anatomy(
        name="built-in head",
        points=_placed(shell.points),
        cells=(CellBlock("wedge", shell.wedges, _layers(shell, held.forehead)),),
        materials=(
            *layer_materials(),
            Yeoh.neo_hookean(LOOSE_STIFFNESS, POISSON),
            Yeoh.neo_hookean(LID_STIFFNESS, POISSON),
            Yeoh.neo_hookean(AREOLAR_STIFFNESS, POISSON),
        ),
        skull=skull.ravel(),
        jaw=jaw.ravel(),
        skin=sheet.triangles + (levels - 1) * count,
        muscles=_muscles(shell),
        jaw_motion=JawMotion(_point(CONDYLE), OPENING_ANGLE, OPENING_SLIDE, FORWARD_SLIDE, SIDEWAYS_SLIDE),
        lids=np.tile(held.lids, levels),
        lid_motion=LidMotion((_point(EYE_CENTRE), _point(EYE_CENTRE, -1.0)), CLOSING_ANGLE),
        epidermis=EPIDERMIS,
        surface=CarriedSurface(_placed(skin.points), skin.triangles, skin.weights, colours),
        companions=_companions(skin),
        bones={
            name: Surface(_placed(bone.points), bone.triangles)
            for name, bone in bones(shell.points[:count], sheet.triangles).items()
        },
        provenance={"source": f"builtin head, size {size}"},
    )


def _placed(points: FloatArray) -> FloatArray:
    """Metres from the sellion."""
    result: FloatArray = METRES * (points - SELLION)
    return result


def _point(centre: FloatArray | tuple[float, float, float], sign: float = 1.0) -> tuple[float, float, float]:
    x, y, z = (float(c) for c in _placed(np.asarray(centre) * [sign, 1.0, 1.0]))
    return x, y, z


def _layers(shell: Shell, forehead: Flags) -> IntArray:
    """Layer of every wedge: by depth, but loose beneath the chin and the galea, and of one kind in the lids.

    forehead (n,) flags deep nodes beneath the galea.
    """
    centre = shell.points[shell.wedges].mean(axis=1)
    deep = shell.layer == shell.layer.max()
    loose = deep & (centre[:, 1] < CHIN) & (centre[:, 2] < THROAT)
    areolar = deep & forehead[shell.wedges[:, :3] % shell.level_size].all(axis=1)
    lid = distance_to_eye(centre) < LID_REACH
    return np.select([lid, loose, areolar], [LID, LOOSE, AREOLAR], shell.layer)


def _muscles(shell: Shell) -> tuple[Muscle, ...]:
    """Muscles of both sides; points of all their lines are looked up at once: surfaces are dear by the look."""
    courses = [course.surface_points() for course in COURSES]
    lines = [line for course in courses for line in course]
    points = _placed(shell.at(*(np.concatenate(parts) for parts in zip(*lines, strict=True))))
    placed = iter(np.split(points, np.cumsum([len(uv) for uv, _ in lines])[:-1]))
    found = []
    for course, given in zip(COURSES, courses, strict=True):
        left = list(islice(placed, len(given)))
        for side, sign in (("L", 1), ("R", -1)):
            fibres = PolylineFibres(tuple(line * [sign, 1.0, 1.0] for line in left), METRES * course.radius, sign)
            found.append(Muscle(f"{course.name}_{side}", fibres, ActiveStress(course.stress)))
    return tuple(found)


def _companions(skin: VisibleSkin) -> dict[str, Companion]:
    found = companions(skin.points, skin.points[skin.border])
    return {name: replace(item, points=_placed(item.points)) for name, item in found.items()}
