"""What is nearest on the other of two sheets, against a look at every triangle, and where triangles meet."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from risorius.adjacency import triangles_across
from risorius.contact_geometry import ContactGeometry
from risorius.errors import InputError
from risorius.lip_search import LipSearch
from risorius.lip_sheets import LipSheets
from risorius.penetration import DEEPEST, PenetrationMeasure
from risorius.poses import Poses

SIDE, EDGE, GAP = 13, 1.5e-3, 1e-3  # points along a sheet; of its squares, metres; between sheets at rest
HALF = EDGE * (SIDE // 2)


def two_sheets():
    """Places (s, 3) of two flat sheets that face each other, the upper one first, and the sheets."""
    along = EDGE * (np.arange(SIDE) - SIDE // 2)
    x, z = (axis.ravel() for axis in np.meshgrid(along, along, indexing="ij"))
    upper = np.column_stack([x, np.full_like(x, 0.5 * GAP), z])
    number = np.arange(SIDE**2).reshape(SIDE, SIDE)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    down = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    triangles = np.concatenate([down, down[:, ::-1] + SIDE**2]).astype(np.int32)
    sheet_of = np.repeat(np.array([0, 1], np.int32), len(down))
    facing = np.full(2 * SIDE**2, len(down), np.int32)
    facing[SIDE**2 :] = 0
    sheets = LipSheets(
        vertices=np.arange(2 * SIDE**2, dtype=np.int32),
        sheet=np.repeat(np.array([0, 1], np.int32), SIDE**2),
        triangles=triangles,
        sheet_of=sheet_of,
        across=triangles_across(triangles),
        facing=facing,
    )
    return np.concatenate([upper, upper * [1.0, -1.0, 1.0]]), sheets


def tangled(rest, rng, size=1.0):
    """Places of sheets that are pushed by up to 4 mm here and there, and shaken."""
    x = rest + 0.1e-3 * size * rng.normal(size=rest.shape)
    for _ in range(8):
        centre, push = rest[rng.integers(len(rest))], 4e-3 * size * rng.uniform(-1.0, 1.0, 3)
        bump = np.exp(-((rest[:, [0, 2]] - centre[[0, 2]]) ** 2).sum(axis=1) / (3e-3) ** 2)
        x += np.where((rest[:, 1] > 0.0) == (centre[1] > 0.0), bump, 0.0)[:, None] * push
    return x


def ways_from_edges(point, start, end):
    """Ways (e, 3) to a point from the nearest places of edges (e, 3)."""
    edge = end - start
    share = np.clip(((point - start) * edge).sum(axis=1) / (edge**2).sum(axis=1), 0.0, 1.0)
    return point - start - share[:, None] * edge


def ways_from_triangles(point, corners):
    """Ways (t, 3) to a point from the nearest places of triangles (3, t, 3), feet in planes or on edges; normals."""
    sides = list(zip(corners, np.roll(corners, -1, axis=0), strict=True))
    normals = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    above = ((point - corners[0]) * normals).sum(axis=1)[:, None] * normals
    inside = np.all([(np.cross(q - p, point - above - p) * normals).sum(axis=1) >= 0.0 for p, q in sides], axis=0)
    ways = np.array([*(ways_from_edges(point, p, q) for p, q in sides), np.where(inside[:, None], above, np.inf)])
    return ways[np.linalg.norm(ways, axis=2).argmin(axis=0), np.arange(len(normals))], normals


@dataclass(frozen=True)
class Found:
    """By a look at all of the other sheet: distance, the triangles that are as near, their cosines, and the border."""

    distance: float
    triangles: np.ndarray
    cosines: np.ndarray
    on_border: bool

    @classmethod
    def of(cls, x, sheets, p):
        other = np.flatnonzero(sheets.sheet_of != sheets.sheet[p])
        ways, normals = ways_from_triangles(x[p], np.moveaxis(x[sheets.triangles[other]], 1, 0))
        distances = np.linalg.norm(ways, axis=1)
        nearest = distances <= distances.min() * (1.0 + 1e-9)
        cosines = (normals * ways).sum(axis=1)[nearest] / distances[nearest]
        ends = np.stack([sheets.triangles, np.roll(sheets.triangles, -1, axis=1)], axis=2)[other]
        start, end = ends[sheets.across[other] < 0].T
        border = np.linalg.norm(ways_from_edges(x[p], x[start], x[end]), axis=1).min()
        return cls(distances.min(), other[nearest], cosines, border <= distances.min() * (1.0 + 1e-9))

    @property
    def clearest(self):
        return np.abs(self.cosines).argmax()


@pytest.mark.parametrize(("within", "size"), [(0.5e-3, 1.0), (4e-3, 1.0), (math.inf, 1.0), (math.inf, 1e4)])
def test_nothing_nearer_is_overlooked_however_sheets_are_tangled(within, size):
    """Also where they are blown up to 40 m, which cells of 2 mm would fill memory for."""
    rest, sheets = two_sheets()
    search, rng = LipSearch(sheets), np.random.default_rng(0)
    for _ in range(3):
        x = tangled(rest, rng, size)
        found = search.nearest(x, np.arange(len(x)), within)
        looked = [Found.of(x, sheets, p) for p in range(len(x))]
        np.testing.assert_array_equal(found.points, [p for p, one in enumerate(looked) if one.distance < within])
        for n, p in enumerate(found.points):
            one = looked[p]
            assert found.distances[n] == pytest.approx(one.distance, rel=1e-9)
            assert found.triangles[n] in one.triangles
            assert found.clearest[n] == one.triangles[one.clearest]
            assert found.cosine[n] == pytest.approx(one.cosines[one.clearest], abs=1e-6)
            assert found.greatest[n] == pytest.approx(one.cosines.max(), abs=1e-6)
            assert found.on_border[n] == one.on_border


def test_measure_counts_what_is_behind_the_clearest_of_the_nearest_triangles_but_not_at_rest():
    rest, sheets = two_sheets()
    half = len(sheets.triangles) // 2
    facing = np.arange(SIDE**2) % half
    seam = np.concatenate([np.column_stack([np.arange(SIDE**2), half + facing]),
                           np.column_stack([SIDE**2 + np.arange(SIDE**2), facing])])  # fmt: skip
    measure = PenetrationMeasure(ContactGeometry({}, seam), Poses(), rest, sheets.triangles)
    normals = np.cross(*(rest[sheets.triangles[:, k]] - rest[sheets.triangles[:, 0]] for k in (1, 2)))
    rng, deep = np.random.default_rng(1), 0
    for _ in range(3):
        x, wanted = tangled(rest, rng), np.zeros(len(rest))
        for p in range(len(x)):
            one = Found.of(x, sheets, p)
            t = one.triangles[one.clearest]
            front = normals[t] @ (rest[p] - rest[sheets.triangles[t, 0]]) >= 0.0
            if one.distance < DEEPEST and one.cosines[one.clearest] < 0.0 and front and not one.on_border:
                wanted[p] = one.distance
        np.testing.assert_allclose(measure.depths_in_lips(x), wanted, rtol=1e-9)
        deep += np.count_nonzero(wanted)
    assert deep > 100


@pytest.mark.parametrize(
    ("x", "z", "on_border", "at_rim"),
    [(0.2e-3, 0.1e-3, False, False), (0.2e-3 - HALF, HALF - 0.3e-3, False, True), (2.0 * HALF, 0.2e-3, True, True)],
)
def test_what_lies_between_vertices_of_the_border_is_at_the_rim(x, z, on_border, at_rim):
    """One corner of the sheet is a triangle between vertices of the border alone."""
    places, sheets = two_sheets()
    places[-1] = x, 0.0, z
    found = LipSearch(sheets).nearest(places, np.array([len(places) - 1]), math.inf)
    assert (bool(found.on_border[0]), bool(found.at_rim[0])) == (on_border, at_rim)


def test_which_points_are_in_front_of_triangles():
    rest, sheets = two_sheets()
    search, points, opposite = LipSearch(sheets), np.array([0, SIDE**2]), np.array([len(sheets.triangles) - 1, 0])
    np.testing.assert_array_equal(search.in_front(rest, points, opposite), [True, True])
    np.testing.assert_array_equal(search.in_front(rest * [1.0, -1.0, 1.0], points, opposite), [False, False])


def test_places_that_are_no_numbers_are_refused():
    rest, sheets = two_sheets()
    rest[7, 1] = np.nan
    with pytest.raises(InputError, match=r"vertex 7 of the lips is at .*; give places that are finite numbers"):
        LipSearch(sheets).nearest(rest, np.arange(len(rest)), math.inf)


def test_without_lips_nothing_is_found():
    rest, sheets = two_sheets()
    nothing = LipSheets.of(np.zeros((0, 2), np.int64), rest, sheets.triangles)
    found = LipSearch(nothing).nearest(rest[:0], np.arange(0), math.inf)
    assert len(found.points) == len(found.greatest) == 0
