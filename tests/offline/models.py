"""Small full models for tests."""

from __future__ import annotations

import numpy as np

from risorius.jaw import JawMotion
from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.anatomy.surface import as_triangles, boundary_faces
from risorius_offline.muscles.loads import ActiveStress
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.polyline_fibres import PolylineFibres
from tests.offline.meshes import box

DRAG = JawMotion((0.0, 0.0, 0.0), 0.0, 0.0, 0.0, sideways_slide=0.008)


def block_anatomy(points, cells, material: Yeoh, *, dragged=None, muscles: tuple[Muscle, ...] = (), fixed=None):
    """A block fixed at z = 0 (or at `fixed`); `dragged` nodes follow jaw_sideways by 8 mm in x."""
    jaw = np.zeros(len(points), dtype=bool) if dragged is None else dragged
    return Anatomy(
        name="block",
        points=points,
        cells=(cells,),
        materials=(material,),
        skull=(np.isclose(points[:, 2], 0.0) if fixed is None else fixed),
        jaw=jaw,
        skin=as_triangles(boundary_faces([cells]), points),
        muscles=muscles,
        jaw_motion=DRAG if dragged is not None else None,
    )


def muscle_block(cell_type: str, material: Yeoh, distortion: float = 0.2, cells=(2, 2, 2)) -> Anatomy:
    """A 20 mm cube, fixed at z = 0, with a muscle along x through its middle."""
    points, block = box(cell_type, cells, distortion=distortion)
    line = np.array([[0.0, 0.01, 0.01], [0.02, 0.01, 0.012]])
    return block_anatomy(
        points, block, material, muscles=(Muscle("pull", PolylineFibres((line,), 0.006), ActiveStress(20e3)),)
    )
