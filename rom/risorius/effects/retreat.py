"""Where a mouth can go back to: a pose that touches next to nothing, for any place of the jaw.

At rest nothing touches. With the jaw opened or pushed forwards, the lower lip goes with it as if it were one with its
teeth, and the upper lip stays; what joins them at the corners of the mouth is in between (harmonic on the surface), and
what is farther away goes as far with the jaw as elastic tissue does. The upper lip goes forwards, too, while the mouth
is closed, else the lower one would come through it; and neither goes aside or back, into the other or the upper teeth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import h5py
import numba
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from risorius.contact_geometry import ContactGeometry
from risorius.effects.skin_around import SkinAround
from risorius.geodesics import distances_from, edge_lengths
from risorius.jaw import FloatArray
from risorius.lip_sheets import LipSheets
from risorius.part import Part
from risorius.poses import Poses

CORNER = 5e-3  # metres along the surface from the other lip, within which neither is stiff
ELASTIC = 20e-3  # metres from the lips, beyond which skin goes with the jaw as tissue does
FADE = 20e-3  # metres beyond what may touch, over which skin goes back less
SHORTEST = 1e-5  # metres of an edge
OPENING = 0.3  # of the jaw, at which it is seen how far tissue goes with it
PARTED = 0.06  # sine of an opening of the jaw, beyond which the lips are apart
_STORED = ("vertices", "carried", "most")


@dataclass(frozen=True)
class Retreat:
    """vertices (w,) that go back, to their places at rest or, by a share carried (w,), to where the jaw takes these.

    most (w,): share of the way that each goes when it is asked to go all of it. rest (n, 3), skin (k, 3): all vertices
    at rest, and triangles.
    """

    vertices: npt.NDArray[np.int32]
    carried: npt.NDArray[np.float32]
    most: npt.NDArray[np.float32]
    rest: npt.NDArray[np.float32]
    skin: npt.NDArray[np.int32]

    @classmethod
    def of(
        cls, geometry: ContactGeometry, poses: Poses, lift_fields: FloatArray, rest: npt.NDArray[np.float32],
        triangles: npt.NDArray[np.int32], touching: npt.NDArray[np.integer],
    ) -> Retreat:  # fmt: skip
        """That of a surface at rest (n, 3), of which some vertices may touch, and fields (lifts, n, 3) of its poses."""
        points = rest.astype(np.float64)
        graph = edge_lengths(points, triangles)
        away = distances_from(graph, touching, FADE)
        near = np.minimum(away / FADE, 1.0)
        most = 1.0 - near * near * (3.0 - 2.0 * near)
        vertices = np.flatnonzero(most > 0.0)
        carried = _carried(LipSheets.of(geometry.seam, rest, triangles), _elastic(poses, lift_fields, points), graph)
        return cls(
            vertices.astype(np.int32),
            carried[vertices].astype(np.float32),
            most[vertices].astype(np.float32),
            rest,
            triangles,
        )

    @cached_property
    def places(self) -> npt.NDArray[np.float32]:
        """(w, 3) of the vertices that go back, at rest."""
        return self.rest[self.vertices]

    @cached_property
    def around(self) -> SkinAround:
        """Skin between the vertices that go back, and what stands for the rest of it."""
        return SkinAround.of(self.vertices, self.rest, self.skin)

    def aim(self, coordinates: FloatArray, transforms: FloatArray, targets: npt.NDArray[np.float32]) -> None:
        """Write where the vertices are, targets (w, 3), when all of the way back is gone.

        transforms (l, 4, 4) of the jaw by the lift coordinates that `coordinates` (r,) begin with, none without a jaw.
        """
        _aim(coordinates, transforms, self.places, self.carried, targets)

    def go(
        self, share: float, targets: npt.NDArray[np.float32], before: npt.NDArray[np.float32],
        vertices: npt.NDArray[np.float32],
    ) -> float:  # fmt: skip
        """Write where `vertices` (n, 3) get from where they were `before` by going a share of the way back.

        Returns metres that any goes at the most.
        """
        return float(_go(np.float32(share), targets, before, self.vertices, self.most, vertices))

    def within(self, part: Part) -> Retreat:
        """That of what a part holds of the face."""
        number = np.full(len(self.rest), -1, np.int32)
        number[part.vertices] = np.arange(len(part.vertices))
        kept = number[self.vertices] >= 0
        skin = number[self.skin]
        return Retreat(
            number[self.vertices[kept]],
            self.carried[kept],
            self.most[kept],
            np.ascontiguousarray(self.rest[part.vertices]),
            np.ascontiguousarray(skin[(skin >= 0).all(axis=1)]),
        )

    def in_axes(self, order: tuple[int, int, int]) -> Retreat:
        """That of vertices whose components are in another order."""
        return replace(self, rest=np.ascontiguousarray(self.rest[:, list(order)]))

    def write(self, group: h5py.Group) -> None:
        """Store all that is not the model's."""
        for name in _STORED:
            group[name] = getattr(self, name)

    @classmethod
    def read(cls, group: h5py.Group) -> Retreat:
        """Load what `write` stored in a model's file."""
        rest, skin = group.file["rest_vertices"][()], group.file["triangles"][()]
        return cls(**{name: group[name][()] for name in _STORED}, rest=rest, skin=skin)


def _elastic(poses: Poses, lift_fields: FloatArray, points: FloatArray) -> FloatArray:
    """(n,) share of an opening of the jaw that tissue follows."""
    if poses.jaw is None:
        return np.zeros(len(points))
    lifts = poses.jaw.lift_coordinates([OPENING, 0.0, 0.0])
    rigid = np.tensordot(lifts, poses.jaw.unit_motions(points), axes=1)
    followed = np.tensordot(lifts, lift_fields[: len(lifts)], axes=1)
    size = np.maximum(np.einsum("ni,ni->n", rigid, rigid), np.finfo(float).tiny)
    return np.clip(np.einsum("ni,ni->n", followed, rigid) / size, 0.0, 1.0)


def _carried(sheets: LipSheets, elastic: FloatArray, graph: sp.csr_matrix) -> FloatArray:
    """(n,) share of the jaw's motion: none of the upper lip, all of the lower one, harmonic between what is known."""
    if not len(sheets.vertices) or not elastic.any():
        return elastic
    upper, lower = (sheets.vertices[sheets.sheet == side] for side in (0, 1))
    known = distances_from(graph, sheets.vertices, ELASTIC) == np.inf
    stiff_upper = upper[distances_from(graph, lower, CORNER)[upper] == np.inf]
    stiff_lower = lower[distances_from(graph, upper, CORNER)[lower] == np.inf]
    carried = elastic.copy()
    carried[stiff_upper], carried[stiff_lower] = 0.0, 1.0
    known[stiff_upper], known[stiff_lower] = True, True
    near = graph + graph.T
    near.data = 1.0 / np.maximum(near.data, SHORTEST)
    laplacian = sp.csr_matrix(sp.diags(np.asarray(near.sum(axis=1)).ravel()) - near)
    free = laplacian[~known]
    carried[~known] = spsolve(sp.csc_matrix(free[:, ~known]), -free[:, known] @ carried[known])
    return carried


@numba.njit(cache=True, error_model="numpy")
def _aim(coordinates, transforms, places, carried, targets):  # type: ignore[no-untyped-def]
    closed = 0.0
    if len(transforms):
        closed = max(0.0, 1.0 - coordinates[0] / PARTED)
    for entry in range(len(places)):
        share = carried[entry]
        for i in range(3):
            moved, pushed = 0.0, 0.0
            for lift in range(min(len(transforms), 3)):
                motion = transforms[lift, i, 3]
                for j in range(3):
                    motion += transforms[lift, i, j] * places[entry, j]
                if lift < 2:
                    moved += coordinates[lift] * motion
                else:
                    pushed = max(coordinates[lift], 0.0) * motion
            targets[entry, i] = places[entry, i] + share * moved + (share + closed * (1.0 - share)) * pushed


@numba.njit(cache=True, error_model="numpy")
def _go(share, targets, before, numbers, most, out):  # type: ignore[no-untyped-def]
    farthest = 0.0
    for entry in range(len(numbers)):
        vertex, part, square = numbers[entry], share * most[entry], 0.0
        for i in range(3):
            way = part * (targets[entry, i] - before[vertex, i])
            out[vertex, i] = before[vertex, i] + way
            square += way * way
        farthest = max(farthest, square)
    return math.sqrt(farthest)
