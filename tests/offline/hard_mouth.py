"""A mouth with teeth behind it, blocks that touch, pads and bars that are dragged, and their hard cases."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from risorius.jaw import JawMotion
from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy.anatomy import Anatomy, Surface
from risorius_offline.anatomy.surface import as_triangles, boundary_faces
from risorius_offline.discretisation import CellBlock
from risorius_offline.effects import Effect
from risorius_offline.effects.bone_contact import BoneContact
from risorius_offline.effects.lip_contact import LipContact
from risorius_offline.muscles.ellipse import Ellipse
from risorius_offline.muscles.loads import ActiveStress
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.ring_fibres import RingFibres
from tests.offline.hard_attempts import HardCase
from tests.offline.hard_models import box_surface, dragging, line, moved_block, pull
from tests.offline.hard_setup import AT_ONCE, at, case
from tests.offline.meshes import box, box_hexahedra

FACIAL = 100e3  # pascals
# jaw_open turns the jaw by 14 degrees and slides it by 2 mm.
JAW = JawMotion((0.0, 0.02, -0.06), 0.25, 0.002, 0.0, 0.003)
CONTACTS: tuple[Callable[[Anatomy], Effect], ...] = (BoneContact, LipContact)


def mouth() -> Anatomy:
    """A sheet, 40 x 32 x 6 mm, with a slit of 1 mm, in front of teeth; skull above and jaw below hold its rim.

    Muscles: a ring around the slit, then up, down and out on the left and on the right.
    """
    unit, cells = box_hexahedra((8, 9, 2), (8.0, 9.0, 2.0))
    heights = 1e-3 * np.array([-16.0, -12.0, -8.0, -4.0, -0.5, 0.5, 4.0, 8.0, 12.0, 16.0])
    points = np.column_stack([5e-3 * (unit[:, 0] - 4.0), heights[np.rint(unit[:, 1]).astype(int)], 3e-3 * unit[:, 2]])
    centre = np.abs(points[cells].mean(axis=1))
    kept = cells[(centre[:, 1] > 1e-3) | (centre[:, 0] > 0.01)]
    block = CellBlock("hexahedron", kept, np.zeros(len(kept), dtype=np.int64))
    x, y, z = points.T
    rim = (z == 0.0) & ((np.abs(x) > 0.0149) | (np.abs(y) > 0.0119)) & (np.abs(y) > 0.0039)
    teeth = {
        "maxilla": box_surface((-0.013, 0.0002, -0.006), (0.013, 0.011, -0.0004)),
        "jaw": box_surface((-0.013, -0.011, -0.006), (0.013, -0.0002, -0.0004)),
    }
    return Anatomy(
        name="mouth",
        points=points,
        cells=(block,),
        materials=(Yeoh(2500.0, 1175.0, 250e3),),
        skull=rim & (y > 0.0),
        jaw=rim & (y < 0.0),
        skin=as_triangles(boundary_faces([block]), points),
        muscles=_around_the_mouth(),
        jaw_motion=JAW,
        bones=teeth,
    )


def _around_the_mouth() -> tuple[Muscle, ...]:
    ellipse = Ellipse((0.0, 0.0, 0.003), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.013, 0.004))
    pulls = [
        pull(f"{name}_{side}", line((sign * x, y, 1e-3), (sign * 8e-3, 0.1 * y, 4e-3)), radius=3e-3, stress=FACIAL)
        for side, sign in (("L", 1.0), ("R", -1.0))
        for name, x, y in (("up", 0.012, 0.016), ("down", 0.012, -0.016), ("out", 0.02, 0.0))
    ]
    return Muscle("ring", RingFibres(ellipse, 3.5e-3), ActiveStress(FACIAL)), *pulls


def blocks(down: float, sideways: float = 0.0, shift: float = 0.0) -> Anatomy:
    """Two 20 mm cubes 1 mm apart, the upper one shifted; it goes down with jaw_forward, aside with jaw_sideways."""
    points, block = box("hexahedron", (3, 3, 2), (0.02,) * 3)
    both = np.concatenate([points, points + np.array([shift, shift, 0.021])])
    cells = np.concatenate([block.connectivity, len(points) + block.connectivity])
    twice = CellBlock("hexahedron", cells, np.zeros(len(cells), dtype=np.int64))
    return moved_block(both, twice, dragging(sideways, -down), np.isclose(both[:, 2], 0.041))


def ball(radius: float, centre: tuple[float, float, float], cells: int = 12) -> Surface:
    """A cube's surface blown up to a sphere."""
    points, hexahedra = box_hexahedra((cells,) * 3, (2.0,) * 3)
    block = CellBlock("hexahedron", hexahedra, np.zeros(len(hexahedra), dtype=np.int64))
    used, triangles = np.unique(as_triangles(boundary_faces([block]), points), return_inverse=True)
    directions = np.tan((points[used] - 1.0) * np.pi / 4)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return Surface(radius * directions + centre, triangles.reshape(-1, 3))


def under(bone: Surface, down: float) -> Anatomy:
    """A 20 mm cube on the skull; the jaw above it goes down by metres with jaw_forward."""
    points, block = box("hexahedron", (4, 4, 4), (0.02,) * 3)
    anatomy = moved_block(points, block, dragging(along=-down), np.zeros(len(points), dtype=bool))
    return replace(anatomy, bones={"jaw": bone})


def pad(sideways: float = 0.0, down: float = 0.0) -> Anatomy:
    """60 x 60 x 12 mm; a patch of its top is dragged along by jaw_sideways, and pushed down by jaw_forward."""
    points, block = box("hexahedron", (6, 6, 3), (0.06, 0.06, 0.012))
    patch = np.isclose(points[:, 2], 0.012) & (np.abs(points[:, :2] - 0.03) <= 0.0101).all(axis=1)
    return moved_block(points, block, dragging(sideways, -down), patch)


def bar(motion: JawMotion, *muscles: Muscle) -> Anatomy:
    """10 x 10 x 60 mm, slender enough to buckle; its far end moves."""
    points, block = box("hexahedron", (2, 2, 8), (0.01, 0.01, 0.06))
    return moved_block(points, block, motion, np.isclose(points[:, 2], 0.06), muscles)


def mouth_cases() -> list[HardCase]:
    """Lips, bones and blocks in contact, and bodies that are dragged far."""
    return [*_lips(), *_touching(), *_dragged()]


def _lips() -> list[HardCase]:
    def doing(ring: float, others: float = 0.0, *jaw: float):
        return at(ring, *[others] * 6, *jaw, *[0.0] * (3 - len(jaw)))

    pucker, opened, everything = doing(1.0), doing(1.0, 0.0, 1.0), doing(1.0, 1.0)
    return [
        case("mouth: every muscle at 1, no contact", mouth, everything),
        case("mouth: pucker at 1", mouth, pucker, *CONTACTS),
        case("mouth: pucker from 0 to 1 in one step", mouth, pucker, *CONTACTS, settings=AT_ONCE),
        case("mouth: pucker from 1 to 0", mouth, doing(0.0), *CONTACTS, start=pucker),
        case("mouth: pucker at 3", mouth, doing(3.0), *CONTACTS),
        case("mouth: every muscle at 1", mouth, everything, *CONTACTS),
        case("mouth: every muscle at 1, jaw open", mouth, doing(1.0, 1.0, 1.0), *CONTACTS),
        case("mouth: pucker at 1, jaw open", mouth, opened, *CONTACTS),
        case("mouth: pucker at 1, jaw sideways", mouth, doing(1.0, 0.0, 0.0, 0.0, 1.0), *CONTACTS),
        case("mouth: jaw closes on a pucker", mouth, pucker, *CONTACTS, start=opened),
    ]


def _touching() -> list[HardCase]:
    down, both = at(0.0, 1.0, 0.0), at(0.0, 1.0, 1.0)
    plate = box_surface((-0.01, -0.01, 0.0205), (0.03, 0.03, 0.03))
    near, far = ball(0.006, (0.01, 0.01, 0.0265)), ball(0.006, (0.01, 0.01, 0.0295))
    return [
        case("blocks pressed together by 14 mm", partial(blocks, 0.015), down, LipContact),
        case("corner of a block pressed 4 mm into a face", partial(blocks, 5e-3, shift=9e-3), down, LipContact),
        case("blocks pressed together, sliding by 8 mm", partial(blocks, 4e-3, 8e-3), both, LipContact),
        case("blocks, into contact in one step", partial(blocks, 5e-3), down, LipContact, settings=AT_ONCE),
        case("plate of bone 7.5 mm into a cube", partial(under, plate, 8e-3), down, BoneContact),
        case("ball of bone 7.5 mm into a cube", partial(under, near, 8e-3), down, BoneContact),
        case("ball of bone into a cube in one step", partial(under, far, 8e-3), down, BoneContact, settings=AT_ONCE),
    ]


def _dragged() -> list[HardCase]:
    forward, sideways, both, turned = at(0.0, 1.0, 0.0), at(0.0, 0.0, 1.0), at(0.0, 1.0, 1.0), at(1.0, 0.0, 0.0)
    half_turn = JawMotion((0.0, 0.005, 0.06), np.pi, 0.0, 0.0, 0.0)
    lower, upper = (
        pull(name, line((0.005, 0.005, low), (0.005, 0.005, low + 0.03)), radius=8e-3, stress=FACIAL)
        for name, low in (("lower", 0.0), ("upper", 0.03))
    )
    stretched = partial(bar, dragging(along=0.12), lower, upper)
    return [
        case("pad of 12 mm dragged by 30 mm", partial(pad, 0.03), sideways),
        case("pad pushed down to half of its height", partial(pad, 0.0, 6e-3), forward),
        case("pad pushed down to half, and dragged by 16 mm", partial(pad, 0.016, 6e-3), both),
        case("pad dragged by 8 mm in one step", partial(pad, 8e-3), sideways, settings=AT_ONCE),
        case("bar turned by 180 degrees at its end", partial(bar, half_turn), turned),
        case("slender bar shortened by a fifth", partial(bar, dragging(along=-0.012)), forward),
        case("slender bar shortened by a half", partial(bar, dragging(along=-0.03)), forward),
        case("tug of war in a bar", partial(bar, dragging(), lower, upper), at(1.0, 1.0, 0.0, 0.0, 0.0)),
        case("tug of war in a bar three times as long", stretched, at(1.0, 1.0, 0.0, 1.0, 0.0)),
    ]
