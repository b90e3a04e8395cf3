"""The visible skin of the built-in head: a finer surface on the mesh, laid back onto the sculpture at rest.

It takes in the skin and the faces through the thickness of lips and lids, so that an open mouth shows lips, not a
sheet.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray
from risorius_offline.head import chart
from risorius_offline.head.border import border_edges
from risorius_offline.head.sheet import Sheet
from risorius_offline.head.shell import Shell
from risorius_offline.head.skin import SKIN
from risorius_offline.subdivision import refine

REFINEMENTS = 2
ROUNDING = 0.05  # share of a point carried by the edge of an opening up to which the sculpture alone gives its place


@dataclass(frozen=True)
class VisibleSkin:
    """points (v, 3) millimetres, triangles, weights (v, nodes), lining (v,): share on the inside of mouth and lids.

    border (k,): numbers of the points on the outer rim of the face.
    """

    points: FloatArray
    triangles: IntArray
    weights: sp.csr_matrix
    lining: FloatArray
    border: IntArray


def visible_skin(sheet: Sheet, shell: Shell, held_rim: npt.NDArray[np.bool_]) -> VisibleSkin:
    """Refine skin and openings; held_rim (n,) flags the sheet's nodes on its outer rim."""
    skin = len(shell.points) - shell.level_size
    edges = border_edges(sheet.triangles)
    edges = edges[~held_rim[edges].all(axis=1)]
    coarse = np.concatenate([sheet.triangles + skin, *_walls(edges, sheet.uv[edges, 0].sum(axis=1) < 0.0, shell)])
    used, coarse = np.unique(coarse, return_inverse=True)
    weights, triangles = refine(coarse.reshape(-1, 3), len(used), REFINEMENTS)
    at_edge = np.isin(used, edges + skin).astype(np.float64)
    on_skin = (used >= skin).astype(np.float64)
    points = weights @ shell.points[used]
    outside, rounded = weights @ on_skin, weights @ at_edge
    laid = np.flatnonzero((outside > 1.0 - 1e-9) & (rounded < ROUNDING))
    uv = (weights @ sheet.uv[used % shell.level_size])[laid]
    origins, directions = chart.rays(uv)
    on_sculpture = origins + chart.outermost(SKIN, uv)[:, None] * directions
    keep = rounded[laid, None] / ROUNDING
    points[laid] = keep * points[laid] + (1.0 - keep) * on_sculpture
    border = np.flatnonzero((weights @ (held_rim[used % shell.level_size] & (used >= skin))) > 1.0 - 1e-9)
    columns = sp.csr_matrix((np.ones(len(used)), (np.arange(len(used)), used)), shape=(len(used), len(shell.points)))
    return VisibleSkin(points, triangles, (weights @ columns).tocsr(), 1.0 - outside, border)


def _walls(edges: IntArray, right: npt.NDArray[np.bool_], shell: Shell) -> list[IntArray]:
    """Triangles through the thickness beneath edges (k, 2), outward; right (k,): the diagonal is mirrored."""
    count = shell.level_size
    walls = []
    for level in range(len(shell.points) // count - 1):
        below, above = edges + level * count, edges + (level + 1) * count
        first, last = np.where(right, below[:, 1], below[:, 0]), np.where(right, above[:, 0], above[:, 1])
        walls.append(np.column_stack([above[:, 1], above[:, 0], first]))
        walls.append(np.column_stack([last, below[:, 0], below[:, 1]]))
    return walls
