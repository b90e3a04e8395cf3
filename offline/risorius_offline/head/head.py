"""Builds the anatomy of the built-in head."""

from __future__ import annotations

import numpy as np

from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy.anatomy import Anatomy, Surface
from risorius_offline.head.bones import bones
from risorius_offline.anatomy.landmarks import jaw_motion
from risorius_offline.anatomy.layers import POISSON, layer_materials
from risorius.jaw import JawMotion
from risorius.lids import LidMotion
from risorius_offline.head.skin import EYE_CENTRE
from risorius_offline.discretisation import CellBlock
from risorius_offline.head import chart
from risorius_offline.head.attachments import attachments
from risorius_offline.head.muscles import COURSES
from risorius_offline.head.openings import lid_margins
from risorius_offline.head.sheet import face_sheet, rim
from risorius_offline.head.shell import layered_shell
from risorius_offline.muscles.loads import ActiveStress
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.polyline_fibres import PolylineFibres

SIZES = {"draft": 2.1, "standard": 1.2, "fine": 0.7}
MM = 1e-3
CLOSING_ANGLE = 0.68
AREOLAR = 1.0e3  # Pa, Young's modulus of the loose tissue on which the scalp glides
ORIGIN = np.array([0.0, 28.0, 92.0])


def built_in_head(size="standard", sheet=None) -> Anatomy:
    sheet = sheet or face_sheet(SIZES[size])
    shell = layered_shell(sheet)
    n = shell.level_size
    levels = len(shell.points) // n
    to_rim = np.maximum(-rim(sheet.uv) - 1e-3, 0.0)
    on_rim = to_rim == 0.0
    held = attachments(shell.points[:n], to_rim, lid_margins()[0])
    skull = np.zeros((levels, n), bool)
    skull[0] = held.skull
    skull[:, on_rim] = True
    jaw, lids = np.zeros((levels, n), bool), np.zeros((levels, n), np.int8)
    jaw[0], lids[0] = held.jaw, held.lids
    centre = shell.points[shell.wedges].mean(axis=1)
    deep_fat = shell.layer == 3
    glide = deep_fat & ((centre[:, 1] > 24.0) | (centre[:, 1] < -76.0) & (centre[:, 2] < 66.0))
    layer = np.where(glide, 4, shell.layer)
    materials = (*layer_materials(), Yeoh.neo_hookean(AREOLAR, POISSON))
    return Anatomy(
        name="built-in head", points=MM * (shell.points - ORIGIN), cells=(CellBlock("wedge", shell.wedges, layer),),
        materials=materials, skull=skull.ravel(), jaw=jaw.ravel(), skin=sheet.triangles + (levels - 1) * n,
        lids=lids.ravel(), lid_motion=LidMotion(tuple(tuple(MM * (np.array(EYE_CENTRE) * [s, 1, 1] - ORIGIN)) for s in (1, -1)), CLOSING_ANGLE),
        muscles=_muscles(shell), jaw_motion=JawMotion(tuple(MM * (np.array([0.0, -2.0, 8.0]) - ORIGIN)), 0.40, 0.013, 0.005, 0.008),
        epidermis=1e-4, bones={k: Surface(MM * (b.points - ORIGIN), b.triangles) for k, b in bones(shell.points[:n], sheet.triangles).items()}, provenance={"source": "builtin"},
    ), sheet


def _muscles(shell):
    out = []
    for course in COURSES:
        lines = [MM * (shell.at(uv, depth) - ORIGIN) for uv, depth in course.surface_points()]
        for side, sign in (("L", 1.0), ("R", -1.0)):
            out.append(Muscle(f"{course.name}_{side}", PolylineFibres(tuple(l * [sign, 1, 1] for l in lines), MM * course.radius), ActiveStress(course.stress)))
    return tuple(out)
