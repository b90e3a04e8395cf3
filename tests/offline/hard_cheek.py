"""A curved cheek between skull and jaw with strong muscles that cross and oppose each other, and its hard cases."""

from __future__ import annotations

from functools import partial

import numpy as np

from risorius.jaw import JawMotion
from risorius.mechanics.fibres import HILL
from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.discretisation import CellBlock
from risorius_offline.muscles.loads import ActiveStress, ForceDensity, Load
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.polyline_fibres import PolylineFibres
from tests.offline.hard_attempts import REFUSED, HardCase, Parameters
from tests.offline.hard_models import line, top_triangles
from tests.offline.hard_setup import AT_ONCE, accelerated, at, case, tense
from tests.offline.meshes import box

# Of deep tissue, muscle, fat and skin: their borders in depth (m) and Young's moduli (Pa).
DEPTHS, YOUNGS = (0.0, 3e-3, 6e-3, 10e-3, 12e-3), (10e3, 20e3, 3e3, 60e3)
FACIAL = ActiveStress(100e3)
# jaw_open turns the jaw by 20 degrees and slides it by 4 mm.
JAW = JawMotion((0.0, 0.02, -0.03), 0.35, 0.004, 0.003, 0.004)
LINES = {
    "up_out": line((0.018, 0.018, 0.003), (-0.004, -0.004, 0.0055)),
    "down_out": line((0.018, -0.018, 0.003), (-0.004, 0.004, 0.0055)),
    "up": line((0.0, 0.018, 0.003), (0.0, -0.002, 0.0055)),
    "down": line((0.0, -0.018, 0.003), (0.0, 0.002, 0.0055)),
    "out": line((0.018, 0.0, 0.003), (-0.002, 0.0, 0.0055)),
    "in": line((-0.018, 0.0, 0.003), (0.002, 0.0, 0.0055)),
}


def cheek(
    cell_type: str = "hexahedron",
    load: Load = FACIAL,
    *,
    cells: int = 6,
    youngs: tuple[float, ...] = YOUNGS,
    depths: tuple[float, ...] = DEPTHS,
    poisson: float = 0.45,
    epidermis: float = 0.0,
) -> Anatomy:
    """40 x 40 x 12 mm in four layers; the upper half of the deep face is skull, its lower third jaw."""
    unit, block = box(cell_type, (cells, cells, 4), (1.0, 1.0, 1.0))
    x, y = 0.04 * unit[:, 0] - 0.02, 0.04 * unit[:, 1] - 0.02
    normal = np.column_stack([x / 0.075, y / 0.12, np.ones_like(x)])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    depth = np.interp(unit[:, 2], np.linspace(0.0, 1.0, 5), depths)
    layer = np.floor(4.0 * unit[block.connectivity].mean(axis=1)[:, 2]).astype(np.int64)
    deep = np.isclose(unit[:, 2], 0.0)
    return Anatomy(
        name="cheek",
        points=np.column_stack([x, y, -(x**2) / 0.15 - y**2 / 0.24]) + depth[:, None] * normal,
        cells=(CellBlock(cell_type, block.connectivity, layer),),
        materials=tuple(Yeoh.neo_hookean(young, poisson) for young in youngs),
        skull=deep & (y > -1e-9),
        jaw=deep & (y < -0.0066),
        skin=top_triangles(unit, block),
        muscles=tuple(Muscle(name, PolylineFibres((ends,), 3e-3), load) for name, ends in LINES.items()),
        jaw_motion=JAW,
        epidermis=epidermis,
    )


def doing(muscles: float = 0.0, *jaw: float, **single: float) -> Parameters:
    """All muscles alike but for single ones, then jaw_open, jaw_forward and jaw_sideways."""
    return at(*(single.get(name, muscles) for name in LINES), *jaw, *[0.0] * (3 - len(jaw)))


ALL, JAW_OPEN, BOTH = doing(1.0), doing(0.0, 1.0), doing(1.0, 1.0)


def cheek_cases() -> list[HardCase]:
    """All at 1, layers of very different stiffness, thin skin, and jumps."""
    return [*_strong(), *_layers(), *_jumps()]


def _strong() -> list[HardCase]:
    vertical, across = doing(up=1.0, down=1.0), doing(**{"in": 1.0, "out": 1.0})
    return [
        case("cheek: all muscles at 1", cheek, ALL),
        case("cheek: antagonists up and down at 1", cheek, vertical),
        case("cheek: antagonists in and out at 1", cheek, across),
        case("cheek: jaw open, forward and sideways at 1", cheek, doing(0.0, 1.0, 1.0, 1.0)),
        case("cheek: all muscles and jaw at 1", cheek, BOTH),
        case("cheek: all muscles and jaw at 1.3", cheek, doing(1.3, 1.3)),
        case("cheek: all muscles at 1, of 300 kPa", partial(cheek, load=ActiveStress(300e3)), ALL),
        case("cheek: all muscles at 1, Hill's law", cheek, ALL, law=HILL),
        case("cheek: all force densities of 2 N/cm3", partial(cheek, load=ForceDensity(2e6)), ALL),
        case("cheek: all muscles at 1, 30 g", cheek, ALL, accelerated(0.0, -294.3, 0.0)),
        case("cheek: all muscles and jaw at 1, pre-stress of 2 MPa", cheek, BOTH, tense(2e6)),
        case("cheek: all muscles and jaw at 1, epidermis", partial(cheek, epidermis=1e-4), BOTH),
        case("cheek of wedges: all muscles and jaw at 1", partial(cheek, "wedge"), BOTH),
        case("cheek of tetra10: all muscles and jaw at 1", partial(cheek, "tetra10", cells=4), BOTH),
        case("cheek: all muscles at 1, Poisson's ratio 0.499", partial(cheek, poisson=0.499), ALL),
        case("cheek: all muscles and jaw at 1, Poisson's ratio 0.4999", partial(cheek, poisson=0.4999), BOTH),
    ]


def _layers() -> list[HardCase]:
    stiff_skin, thin = (1e3, 1e3, 1e3, 1e6), (*DEPTHS[:-1], 10.5e-3)
    paper = partial(cheek, depths=(*DEPTHS[:-1], 10.1e-3), youngs=(*YOUNGS[:-1], 1e6))
    sandwich, soft_muscle = (1e3, 1e6, 1e3, 1e6), (1e6, 1e3, 1e6, 1e6)
    both = "cheek: all muscles and jaw at 1"
    return [
        case("cheek: skin 1000 times stiffer, all muscles at 1", partial(cheek, youngs=stiff_skin), ALL),
        case("cheek: skin 1000 times stiffer, jaw at 1", partial(cheek, youngs=stiff_skin), JAW_OPEN),
        case(f"{both}, deep tissue 1000 times stiffer", partial(cheek, youngs=stiff_skin[::-1]), BOTH),
        case(f"{both}, layers 1:1000:1:1000", partial(cheek, youngs=sandwich), BOTH),
        case(f"{both}, layers 1000:1:1000:1000", partial(cheek, youngs=soft_muscle), BOTH),
        case(f"{both}, skin of 0.5 mm", partial(cheek, depths=thin), BOTH),
        case("cheek: skin of 0.5 mm 1000 times stiffer, all at 1", partial(cheek, depths=thin, youngs=stiff_skin), ALL),
        case("cheek: skin of 0.1 mm and 1 MPa, all muscles at 1", paper, ALL),
    ]


def _jumps() -> list[HardCase]:
    """The straight way of the jaw back to rest inverts cells; muscles that push have no equilibrium."""
    up, down = doing(up=1.0), doing(down=1.0)
    refused = {"settings": AT_ONCE, "start": BOTH, "expect": REFUSED}
    return [
        case("cheek: all muscles from 0 to 1 in one step", cheek, ALL, settings=AT_ONCE),
        case("cheek: all muscles from 1 to 0 in one step", cheek, doing(), settings=AT_ONCE, start=ALL),
        case("cheek: all muscles and jaw from 0 to 1 in one step", cheek, BOTH, settings=AT_ONCE),
        case("cheek: all muscles and jaw from 1 to 0 in one step", cheek, doing(), **refused),
        case("cheek: all muscles and jaw from 1 to 0", cheek, doing(), start=BOTH),
        case("cheek: from muscle to antagonist in one step", cheek, down, settings=AT_ONCE, start=up),
        case("cheek: all muscles at -0.1", cheek, doing(-0.1), expect=REFUSED),
    ]
