"""Rigid things seen with the built-in head: eyeballs, teeth, tongue, throat, and the rest of the head with its ears."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from risorius.companion import JAW, SKULL, Companion
from risorius.jaw import FloatArray
from risorius_offline.discretisation import IntArray
from risorius_offline.head import colours
from risorius_offline.head.skin import EYE_CENTRE, EYE_RADIUS, SKIN

RINGS, SECTORS = 32, 48
IRIS_RADIUS, PUPIL_RADIUS = 5.9, 2.4
# 3 mm within the bones that tissue slides on, which are smoothed over the spacing of its nodes: skin between two nodes
# then stays out of the teeth that are seen.
ARCH_WIDTH, ARCH_BACK, ARCH_DEPTH = 22.0, 52.0, 33.0
TOOTH_WIDTHS = 7.2  # mean, along the arch
GROOVE, TOOTH_THICKNESS = 0.7, 6.0
UPPER_TEETH, LOWER_TEETH = (-46.7, -36.5, -30.0), (-47.9, -57.0, -62.0)  # edge, neck, end of the gum; apart at rest
OVERJET = 2.0
HEAD_CENTRE, NECK_END = (0.0, 10.0, -12.0), (0.0, -146.0, -39.0)
HEAD_STEP, NECK_ROWS = np.radians(3.0), 20
LOWEST = np.radians(-24.0)  # elevation from which the rays' origins go down the neck, while they become level
UNDER_THE_FACE, OVERLAP, FLUSH = 0.9, 9.0, 4.0
EAR_CENTRE, EAR_SIZE, EAR_TILT, EAR_FLARE = (69.5, 4.0, -8.0), (17.0, 31.0), 12.0, 28.0


def companions(face: FloatArray, rim: FloatArray) -> dict[str, Companion]:
    """Companions in millimetres. face (v, 3): visible points at rest; rim (k, 3): those on the face's outer border."""
    found = {
        "teeth_upper": _teeth(UPPER_TEETH, 0.0, SKULL),
        "teeth_lower": _teeth(LOWER_TEETH, OVERJET, JAW),
        "tongue": _ellipsoid((0.0, -58.0, 57.0), (15.0, 7.5, 20.0), colours.TONGUE, JAW),
        "throat": _ellipsoid((0.0, -48.0, 46.0), (40.0, 28.0, 23.0), colours.THROAT, SKULL),
        "head": _rest_of_head(face, rim),
    }
    for side, sign in (("left", 1.0), ("right", -1.0)):
        centre = (sign * EYE_CENTRE[0], EYE_CENTRE[1], EYE_CENTRE[2])
        found[f"eyeball_{side}"] = _eyeball(centre)
        lining = (centre[0], centre[1] + 0.2, centre[2] - 3.5)
        found[f"eye_lining_{side}"] = _ellipsoid(lining, (14.6, 10.0, 9.0), colours.LID_LINING, SKULL)
        found[f"ear_{side}"] = _ear(sign)
    return found


def _painted(points: FloatArray, triangles: IntArray, colour: tuple[int, int, int], moves_with: str) -> Companion:
    return Companion(points, triangles, np.tile(np.array(colour, dtype=np.uint8), (len(points), 1)), moves_with)


def _globe() -> tuple[FloatArray, IntArray]:
    """Unit sphere with its pole towards z, points ring by ring, outward triangles."""
    polar = np.linspace(0.0, np.pi, RINGS + 1)[1:-1]
    around = np.linspace(0.0, 2.0 * np.pi, SECTORS, endpoint=False)
    t, p = np.meshgrid(polar, around, indexing="ij")
    rings = np.column_stack([(np.sin(t) * np.cos(p)).ravel(), (np.sin(t) * np.sin(p)).ravel(), np.cos(t).ravel()])
    points = np.vstack([[0.0, 0.0, 1.0], rings, [0.0, 0.0, -1.0]])
    first, last = 1 + np.arange(SECTORS), 1 + (RINGS - 2) * SECTORS + np.arange(SECTORS)
    top = np.column_stack([np.zeros(SECTORS, dtype=np.int64), first, np.roll(first, -1)])
    bottom = np.column_stack([np.full(SECTORS, len(points) - 1), np.roll(last, -1), last])
    return points, np.concatenate([top, _grid(RINGS - 1, SECTORS, closed=True) + 1, bottom])


def _grid(rows: int, columns: int, *, closed: bool) -> IntArray:
    """Triangles of a lattice of points numbered row by row; closed: the last column joins the first."""
    number = np.arange(rows * columns).reshape(rows, columns)
    right = np.roll(number, -1, axis=1)
    if not closed:
        number, right = number[:, :-1], right[:, :-1]
    a, b, c, d = number[:-1].ravel(), number[1:].ravel(), right[1:].ravel(), right[:-1].ravel()
    return np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def _ellipsoid(
    centre: tuple[float, float, float], radii: tuple[float, float, float], colour: tuple[int, int, int], moves: str
) -> Companion:
    points, triangles = _globe()
    return _painted(points * radii + centre, triangles, colour, moves)


def _eyeball(centre: tuple[float, float, float]) -> Companion:
    """Eyeball that looks ahead."""
    points, triangles = _globe()
    away = np.arccos(np.clip(points[:, 2], -1.0, 1.0)) * EYE_RADIUS
    edges = np.arcsin(np.array([PUPIL_RADIUS, IRIS_RADIUS]) / EYE_RADIUS) * EYE_RADIUS
    colour = np.where((away < edges[1])[:, None], np.array(colours.IRIS), np.array(colours.SCLERA))
    colour = np.where((away < edges[0])[:, None], np.array(colours.PUPIL), colour)
    return Companion(points * EYE_RADIUS + np.array(centre), triangles, colour.astype(np.uint8))


def _teeth(heights: tuple[float, float, float], behind: float, moves: str) -> Companion:
    """A row of teeth with gum: front, edge and back of a band along the arch, with a groove between teeth."""
    edge, neck, end = heights
    angle = np.radians(np.linspace(-82.0, 82.0, 241))
    curve = np.column_stack([ARCH_WIDTH * np.sin(angle), ARCH_BACK - behind + ARCH_DEPTH * np.cos(angle)])
    outward = np.column_stack([np.sin(angle) / ARCH_WIDTH, np.cos(angle) / ARCH_DEPTH])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    along -= along[len(along) // 2]
    groove = GROOVE * np.exp(-(((np.mod(along / TOOTH_WIDTHS + 0.5, 1.0) - 0.5) / 0.09) ** 2))
    thick = TOOTH_THICKNESS
    profile = ((end, -1.0, 0.0), (neck, 0.4, 0.4), (neck, 0.0, 1.0), (0.5 * (neck + edge), 0.0, 1.0),
               (edge, -0.8, 1.0), (edge, -2.2, 1.0), (neck, -thick, 0.0), (end, -thick, 0.0))  # fmt: skip
    rows, paint = [], []
    for number, (height, out, grooved) in enumerate(profile):
        place = curve + (out - grooved * groove)[:, None] * outward
        rows.append(np.column_stack([place[:, 0], np.full(len(place), height), place[:, 1]]))
        paint.append(np.tile(colours.GUMS if number in (0, 1, 7) else colours.TEETH, (len(place), 1)))
    triangles = _grid(len(profile), len(curve), closed=False)
    if edge > neck:
        triangles = triangles[:, ::-1]
    return Companion(np.concatenate(rows), triangles, np.concatenate(paint).astype(np.uint8), moves)


def _rest_of_head(face: FloatArray, rim: FloatArray) -> Companion:
    """Scalp, nape and neck, by rays from inside the head, reaching a little way under the face's rim."""
    origins, directions, columns = _rays_about_the_head()
    points = _first_surface(origins, directions)
    triangles = _grid(len(points) // columns, columns, closed=True)
    to_face, to_rim = cKDTree(face).query(points)[0], cKDTree(rim).query(points)[0]
    shown = (to_rim < OVERLAP) | (to_face > OVERLAP)
    triangles = triangles[shown[triangles].all(axis=1)]
    # Flush with the face's skin beyond its rim, beneath it on this side.
    beyond = np.where(to_face < to_rim, -to_rim, to_rim)
    depth = UNDER_THE_FACE * np.clip(0.5 - 0.5 * beyond / FLUSH, 0.0, 1.0)
    used, triangles = np.unique(triangles, return_inverse=True)
    points = points - depth[:, None] * directions
    return _painted(points[used], triangles.reshape(-1, 3), colours.SKIN, SKULL)


def _rays_about_the_head() -> tuple[FloatArray, FloatArray, int]:
    """Origins and unit directions, (n, 3) each, row by row from the vertex to the end of the neck; rays in a row."""
    down = np.linspace(0.0, 1.0, NECK_ROWS + 1)[1:]
    elevation = np.arange(0.5 * np.pi - 0.5 * HEAD_STEP, LOWEST, -HEAD_STEP)
    going = np.concatenate([np.zeros(len(elevation)), down])
    elevation = np.concatenate([elevation, elevation[-1] * (1.0 - down)])
    around = np.arange(0.0, 2.0 * np.pi, HEAD_STEP)
    e, a = np.meshgrid(elevation, around, indexing="ij")
    directions = np.column_stack([(np.cos(e) * np.sin(a)).ravel(), np.sin(e).ravel(), (np.cos(e) * np.cos(a)).ravel()])
    share = np.repeat(going, len(around))[:, None]
    return (1.0 - share) * HEAD_CENTRE + share * NECK_END, directions, len(around)


def _first_surface(origins: FloatArray, directions: FloatArray) -> FloatArray:
    """Last point of the skin's sculpture on rays from inside the head."""
    distances = np.linspace(30.0, 190.0, 81)
    inside = np.full(len(directions), 30.0)
    for distance in distances:
        within = SKIN.distance(origins + distance * directions) < 0.0
        inside[within] = distance
    outside = inside + (distances[1] - distances[0])
    for _ in range(16):
        middle = 0.5 * (inside + outside)
        within = SKIN.distance(origins + middle[:, None] * directions) < 0.0
        inside, outside = np.where(within, middle, inside), np.where(within, outside, middle)
    return origins + inside[:, None] * directions


def _ear(sign: float) -> Companion:
    """A plain auricle: helix, antihelix, concha and lobule as heights over an egg-shaped disc."""
    radius, around = np.linspace(0.02, 1.0, 22), np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    r, a = np.meshgrid(radius, around, indexing="ij")
    narrowing = 1.0 - 0.28 * np.clip(-np.sin(a), 0.0, 1.0)
    back, up = -EAR_SIZE[0] * r * np.cos(a) * narrowing, EAR_SIZE[1] * r * np.sin(a)
    helix = 3.2 * np.exp(-(((r - 0.9) / 0.10) ** 2)) * np.clip(0.75 + 0.6 * np.sin(a), 0.0, 1.0)
    antihelix = 2.6 * np.exp(-(((r - 0.6) / 0.12) ** 2)) * np.clip(0.5 - np.cos(a), 0.0, 1.0)
    concha = -6.0 * np.exp(-(((r - 0.15) / 0.3) ** 2))
    front = np.stack([helix + antihelix + concha, up, back], axis=-1)
    rear = np.stack([-2.5 - 4.0 * (1.0 - r), up, back], axis=-1)[::-1]
    local = np.concatenate([front, rear]).reshape(-1, 3)
    flare, tilt = np.radians(EAR_FLARE), np.radians(EAR_TILT)
    outward = np.column_stack([
        local[:, 0] * np.cos(flare) - local[:, 2] * np.sin(flare), local[:, 1],
        local[:, 0] * np.sin(flare) + local[:, 2] * np.cos(flare),
    ])  # fmt: skip
    turned = np.column_stack([
        outward[:, 0], outward[:, 1] * np.cos(tilt) + outward[:, 2] * np.sin(tilt),
        outward[:, 2] * np.cos(tilt) - outward[:, 1] * np.sin(tilt),
    ])  # fmt: skip
    points = (turned + np.array(EAR_CENTRE)) * [sign, 1.0, 1.0]
    triangles = _grid(2 * len(radius), len(around), closed=True)
    return _painted(points, triangles if sign > 0 else triangles[:, ::-1], colours.SKIN, SKULL)
