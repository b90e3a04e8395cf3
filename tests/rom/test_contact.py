"""Contact on surfaces whose depth in what they touch is known exactly: a sheet on a ball, and two sheets that face."""

import h5py
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.walled_model import AT_REST, JAW_MOTION, NO_SEAM, contact_of

from risorius.companion import JAW, SKULL, unit_transforms
from risorius.contact_geometry import ContactGeometry, Obstacle
from risorius.effects.contact import Contact
from risorius.effects.contact_patches import beyond_leaders, take_off_shifts
from risorius.effects.contact_proof import _beside
from risorius.effects.contact_sweeps import ENOUGH, FARTHEST
from risorius.effects.correction_fields import RADIUS
from risorius.effects.lip_gaps import DUBIOUS, SEARCHED, TOLERATED, leave_beside
from risorius.effects.retreat import Retreat
from risorius.effects.teeth_blocks import beyond_blocks
from risorius.effects.teeth_gaps import APART
from risorius.engine import Engine
from risorius.errors import InputError
from risorius.gauntlet.case import Ask, Bench
from risorius.gauntlet.judge import Judge
from risorius.guard import UNFOLDED
from risorius.normals import vertex_normals
from risorius.part import Part
from risorius.penetration import OUT_OF_ITSELF, PenetrationMeasure
from risorius.poses import Poses
from risorius.scene import Scene

BALL, EDGE, SIDE = 10e-3, 1e-3, 41  # radius; of the sheet's squares; points along it


def ball(moves_with=SKULL):
    """A ball about the origin, sampled as teeth are."""
    axis = 0.75e-3 * np.arange(-24, 25)
    x, y, z = np.meshgrid(axis, axis, axis, indexing="ij")
    distances = np.clip(np.sqrt(x**2 + y**2 + z**2) - BALL, -6e-3, 6e-3)
    return Obstacle(np.full(3, axis[0]), 0.75e-3, distances.astype(np.float32), moves_with)


def sheet(height, finer=1):
    """Points (n, 3) of a flat sheet that faces z, and its triangles; its squares may be several times finer."""
    side = finer * (SIDE - 1) + 1
    along = EDGE / finer * (np.arange(side) - side // 2)
    x, y = np.meshgrid(along, along, indexing="ij")
    number = np.arange(side * side).reshape(side, side)
    a, b, c, d = number[:-1, :-1].ravel(), number[1:, :-1].ravel(), number[1:, 1:].ravel(), number[:-1, 1:].ravel()
    right = (np.arange(len(a)) // (side - 1) >= side // 2)[:, None]  # diagonals are mirror images, too
    triangles = np.concatenate([np.where(right, np.column_stack([a, b, c]), np.column_stack([a, b, d])),
                                np.where(right, np.column_stack([a, c, d]), np.column_stack([b, c, d]))])  # fmt: skip
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, height)]).astype(np.float32), triangles.astype(
        np.int32
    )


def on_ball(moves_with=SKULL):
    """Contact of a sheet that lies 1 mm off a ball at rest."""
    rest, triangles = sheet(BALL + 1e-3)
    geometry = ContactGeometry({"ball": ball(moves_with)}, NO_SEAM)
    return contact_of(geometry, rest, triangles, rest - [0.0, 0.0, 3e-3]), rest.astype(np.float32)


def pressed(rest, depth):
    return (rest - [0.0, 0.0, 1e-3 + depth]).astype(np.float32)


def depths(vertices):
    return BALL - np.linalg.norm(vertices.astype(np.float64), axis=1)


@pytest.mark.parametrize("depth", [0.4e-3, 1e-3, 2e-3])
def test_skin_in_a_tooth_is_moved_out_of_it(depth):
    contact, rest = on_ball()
    vertices = pressed(rest, depth)
    assert depths(vertices).max() == pytest.approx(depth, abs=1e-6)
    contact.finish(AT_REST, vertices)
    assert depths(vertices).max() < 0.15e-3


def test_what_is_as_shallow_as_at_equilibria_is_left_as_it_is():
    contact, rest = on_ball()
    vertices = pressed(rest, 0.18e-3)
    before = vertices.copy()
    contact.finish(AT_REST, vertices)
    np.testing.assert_array_equal(vertices, before)


def test_what_moves_fades_out_and_nothing_dents():
    """From one vertex to the next the correction changes by at most what the bumps' slope, 2.1 / RADIUS, allows."""
    contact, rest = on_ball()
    vertices = pressed(rest, 1e-3)
    before = vertices.copy()
    contact.finish(AT_REST, vertices)
    moved = np.linalg.norm(vertices - before, axis=1).reshape(SIDE, SIDE)
    steps = max(np.abs(np.diff(moved, axis=0)).max(), np.abs(np.diff(moved, axis=1)).max())
    assert steps < 2.1 / RADIUS * EDGE * moved.max()
    assert moved.max() < 1.6e-3
    assert (moved[[0, -1]] == 0.0).all()
    assert (moved[:, [0, -1]] == 0.0).all()


def test_a_face_that_touches_nothing_stays_as_it_is_bit_for_bit():
    contact, rest = on_ball()
    vertices = rest.copy()
    contact.finish(AT_REST, vertices)
    np.testing.assert_array_equal(vertices, rest)


def test_skin_that_nothing_comes_near_costs_no_points():
    rest, triangles = sheet(BALL + 7e-3)
    contact = contact_of(ContactGeometry({"ball": ball()}, NO_SEAM), rest, triangles, rest)
    assert (len(contact.tables.points), len(contact.tables.vertices)) == (0, 0)
    contact.finish(AT_REST, rest)


def test_a_correction_does_not_depend_on_the_frames_before():
    contact, rest = on_ball()
    first, other, again = pressed(rest, 1e-3), pressed(rest, 2.5e-3), pressed(rest, 1e-3)
    contact.finish(AT_REST, first)
    contact.finish(AT_REST, other)
    contact.finish(AT_REST, again)
    np.testing.assert_array_equal(first, again)


def test_both_sides_are_corrected_alike():
    contact, rest = on_ball()
    vertices = pressed(rest, 1e-3)
    contact.finish(AT_REST, vertices)
    height = vertices[:, 2].reshape(SIDE, SIDE)
    np.testing.assert_allclose(height, height[::-1], atol=5e-5)


def test_teeth_of_the_jaw_move_with_it():
    """Sheet and ball moved together by the jaw give what they give at rest, moved, up to where sweeps may end."""
    contact, rest = on_ball(JAW)
    lifts = JAW_MOTION.lift_coordinates([0.8, 0.3, -0.5])

    def carried(points):
        points = points.astype(np.float64)
        return points + np.tensordot(lifts, JAW_MOTION.unit_motions(points), axes=1)

    still = pressed(rest, 1e-3)
    moved = carried(still).astype(np.float32)
    contact.finish(AT_REST, still)
    contact.finish(lifts, moved)
    np.testing.assert_allclose(moved, carried(still), atol=ENOUGH)


@pytest.mark.parametrize("order", [(2, 0, 1), (1, 0, 2)])
@pytest.mark.parametrize("made", [on_ball, lambda: lips()])
def test_other_axes_give_the_same_face(order, made):
    contact, rest = made()
    lifts = JAW_MOTION.lift_coordinates([0.01, 0.0, 0.0])
    vertices = pressed(rest, 1e-3) if len(rest) == SIDE**2 else closed(rest, 2e-3)
    vertices[SIDE**2 :, 1] += (vertices[SIDE**2 :, [0, 2]] @ [0.013, 0.007]).astype(np.float32)  # no two are as deep
    turned = np.ascontiguousarray(vertices[:, order])
    contact.finish(lifts, vertices)
    contact.in_axes(order).finish(lifts, turned)
    np.testing.assert_allclose(turned, vertices[:, order], atol=1e-6)


def test_a_file_gives_back_the_effect():
    contact, rest = on_ball()
    vertices = pressed(rest, 1e-3)
    again = vertices.copy()
    with h5py.File("contact", "w", driver="core", backing_store=False) as memory:
        memory["rest_vertices"], memory["triangles"] = contact.retreat.rest, contact.retreat.skin
        contact.write(memory.create_group("contact"))
        read = Contact.read(memory["contact"])
    contact.finish(AT_REST, vertices)
    read.finish(AT_REST, again)
    np.testing.assert_array_equal(vertices, again)
    assert read.fields.shape == (0, 5, 3)


def test_a_part_of_a_face_is_corrected_where_it_is():
    contact, rest = on_ball()
    half = np.flatnonzero(rest[:, 0] <= 1e-9)
    none = np.zeros(0, np.int64)
    part = Part(none, np.zeros(0, bool), np.arange(4), none, none, half, 4)
    vertices = pressed(rest, 1e-3)[half]
    contact.within(part).finish(AT_REST, vertices)
    assert depths(vertices).max() < 0.15e-3


def facing(triangles):
    """Triangles of a sheet, then of one above it that faces it."""
    return np.concatenate([triangles, triangles[:, ::-1] + triangles.max() + 1]).astype(np.int32)


def lips(gap=1e-3, finer=1):
    """Two sheets, one above the other, that face each other at rest."""
    flat, triangles = sheet(0.0, finer)
    lower = flat[:, [1, 2, 0]] + [0.0, -0.5 * gap, 0.0]
    upper = flat[:, [1, 2, 0]] + [0.0, 0.5 * gap, 0.0]
    rest = np.concatenate([lower, upper]).astype(np.float32)
    all_triangles = facing(triangles)
    below, above = np.arange(len(triangles)), len(triangles) + np.arange(len(triangles))
    inner = (np.abs(rest[triangles].mean(axis=1)[:, [0, 2]]) < 5e-3).all(axis=1)
    seam = np.concatenate([np.column_stack([triangles[inner, 0], above[inner]]),
                           np.column_stack([triangles[inner, 0] + len(flat), below[inner]])])  # fmt: skip
    geometry = ContactGeometry({}, seam)
    return contact_of(geometry, rest, all_triangles, closed(rest, 2e-3, gap)), rest


def closed(rest, overlap, gap=1e-3):
    """The upper sheet bulges down through the lower one."""
    upper = np.arange(len(rest)) >= len(rest) // 2
    away = np.linalg.norm(rest[:, [0, 2]], axis=1)
    bulge = (gap + overlap) * np.exp(-((away / 6e-3) ** 2))
    return (rest - np.where(upper, bulge, 0.0)[:, None] * [0.0, 1.0, 0.0]).astype(np.float32)


def test_no_vertex_of_fine_lips_gets_into_the_other_unseen():
    """Each by itself, 0.8 mm deep: whoever looks at some of the vertices does not see what the others do."""
    contact, rest = lips(finer=2)
    inner = np.abs(rest[:, [0, 2]]).max(axis=1) < 9e-3
    upper = np.arange(len(rest)) >= len(rest) // 2
    found = []
    for vertex in np.flatnonzero(inner & upper)[::3]:
        vertices = rest.copy()
        vertices[vertex, 1] -= 1.8e-3
        found.append(contact._look.find(vertices, False))
    np.testing.assert_allclose(found, 0.8e-3, atol=1e-6)


@pytest.mark.parametrize("overlap", [0.5e-3, 1e-3, 2e-3])
def test_lips_that_are_in_each_other_part(overlap):
    contact, rest = lips()
    vertices = closed(rest, overlap)
    contact.finish(AT_REST, vertices)
    lower, upper = np.split(vertices[:, 1], 2)
    assert (lower - upper).max() < 0.15e-3
    assert lower.min() < -0.5e-3 - 0.3 * overlap  # both give way


def test_measure_tells_depths_in_teeth_and_lips():
    rest, triangles = sheet(BALL + 1e-3)
    measure = PenetrationMeasure(ContactGeometry({"ball": ball()}, NO_SEAM), Poses(), rest, triangles)
    assert measure(rest, AT_REST).teeth == 0.0
    assert measure(pressed(rest, 0.8e-3), AT_REST).teeth == pytest.approx(0.8e-3, abs=0.02e-3)
    contact, rest = lips()
    triangles = sheet(0.0)[1]
    triangles = np.concatenate([triangles, triangles[:, ::-1] + SIDE**2]).astype(np.int32)
    measure = PenetrationMeasure(contact.geometry, Poses(), rest, triangles)
    assert measure(rest, AT_REST).lips == 0.0
    assert measure(closed(rest, 0.8e-3), AT_REST).lips == pytest.approx(0.8e-3, abs=0.02e-3)


def test_measure_does_not_count_what_went_around_the_rim_of_the_other_lip():
    contact, rest = lips()
    flat, count = sheet(0.0)[1], SIDE**2
    rest = np.concatenate([rest, rest[:count] - [0.0, 1.5e-3, 0.0]])  # closes the lower lip below
    triangles = np.concatenate([flat, flat[:, ::-1] + count, flat[:, ::-1] + 2 * count]).astype(np.int32)
    measure = PenetrationMeasure(contact.geometry, Poses(), rest.astype(np.float32), triangles)
    middle = count + count // 2  # of the upper lip
    inside, around = rest.astype(np.float32), rest.astype(np.float32)
    inside[middle, 1], around[middle, 1] = -1.3e-3, -2.5e-3
    assert measure(inside, AT_REST).lips == pytest.approx(0.8e-3, abs=0.02e-3)
    assert measure.depths_in_lips(around).max() == pytest.approx(2e-3, abs=0.02e-3)
    assert measure(around, AT_REST).lips < 0.5e-3  # what it draws through the lower lip on its way


def test_vertices_that_are_no_numbers_are_left_alone():
    contact, rest = on_ball()
    vertices = np.full_like(rest, np.nan)
    contact.finish(AT_REST, vertices)
    assert np.isnan(vertices).all()


def test_scene_asks_for_contact_of_a_model_that_has_it(synthetic_model):
    with pytest.raises(InputError, match="contact: model 'synthetic' is without; train it from snapshots with contact"):
        Engine(synthetic_model, Scene(contact=True))


@pytest.mark.parametrize("depth", [-4e-3, -0.9e-3, 0.5e-3])
def test_what_blocks_of_a_grid_leave_is_less_than_the_gap(depth):
    """Of the sheet around a ball, most of which is clear."""
    contact, rest = on_ball()
    look = contact._look
    x = pressed(rest, depth)
    (ball,) = contact.geometry.obstacles.values()
    exact, gaps = ball.distance(x)[contact.tables.points], np.full(len(contact.tables.points), APART)
    _, onsets, *space = look._blocks
    places = np.ascontiguousarray(x[contact.tables.points].T)
    beyond_blocks(places, onsets, *look._teeth[5:], *space, gaps)
    clear = gaps > 0.0
    assert (gaps[clear] <= exact[clear] + 1e-7).all()
    assert clear.mean() > (0.5 if depth < 0.0 else 0.2)


def test_what_has_moved_less_than_its_gap_touches_nothing():
    contact, rest = on_ball()
    x = pressed(rest, -0.2e-3)
    points, rng = contact.tables.points, np.random.default_rng(2)
    gaps = -depths(x)[points]
    shifts = 1e-3 * rng.standard_normal(x.shape) * (rng.random((len(x), 1)) < 0.3)
    x += shifts
    take_off_shifts(points, shifts, np.linalg.norm(shifts, axis=1).max(), gaps)
    assert (gaps <= -depths(x)[points] + 1e-7).all()


def test_skin_deeper_than_sweeps_can_mend_goes_back_as_far_as_it_has_to():
    """Sweeps move nothing by more than 8 mm: a sheet 12 mm in a ball comes out by going back, too."""
    contact, rest = on_ball()
    vertices = pressed(rest, 12e-3)
    contact.finish(AT_REST, vertices)
    assert depths(vertices).max() < TOLERATED + 0.05e-3
    moved = vertices[:, 2] - pressed(rest, 12e-3)[:, 2]
    assert moved.max() < 13.5e-3
    assert moved.max() > 8e-3


@pytest.fixture(scope="module")
def retreat():
    """Of sheets that elastic tissue would take half of the way with the jaw, all of which may touch."""
    geometry, rest = lips()[0].geometry, lips()[1]
    triangles = facing(sheet(0.0)[1])
    half = 0.5 * JAW_MOTION.unit_motions(rest.astype(np.float64))
    return Retreat.of(geometry, Poses(JAW_MOTION), half, rest, triangles, np.arange(len(rest))), rest


def gone_back(retreat, rest, jaw, share=1.0):
    """Where a face 5 mm from rest gets to by going back with the jaw at weights (3,)."""
    before = (rest + 5e-3).astype(np.float32)
    vertices, targets = before.copy(), np.empty_like(retreat.places)
    retreat.aim(JAW_MOTION.lift_coordinates(jaw), unit_transforms(JAW_MOTION), targets)
    return vertices, retreat.go(share, targets, before, vertices)


def test_a_mouth_goes_back_to_rest_with_the_lower_lip_on_the_opened_jaw(retreat):
    retreat, rest = retreat
    still, way = gone_back(retreat, rest, [0.5, 0.0, 0.0], share=0.0)
    np.testing.assert_array_equal(still, (rest + 5e-3).astype(np.float32))
    assert way == 0.0
    vertices, _ = gone_back(retreat, rest, [0.5, 0.0, 0.0])
    upper, middle = rest[:, 1] > 0.0, np.abs(rest[:, [0, 2]]).max(axis=1) < 4e-3
    np.testing.assert_allclose(vertices[upper & middle], rest[upper & middle], atol=1e-6)
    points = rest[~upper & middle].astype(np.float64)
    lifts = JAW_MOTION.lift_coordinates([0.5, 0.0, 0.0])
    carried = points + np.tensordot(lifts, JAW_MOTION.unit_motions(points), axes=1)
    np.testing.assert_allclose(vertices[~upper & middle], carried, atol=1e-6)


@pytest.mark.parametrize("forward", [-1.0, 0.0, 1.0])
@pytest.mark.parametrize("sideways", [-1.0, 1.0])
def test_lips_do_not_cross_where_a_mouth_has_gone_back_with_the_jaw_closed(retreat, forward, sideways):
    """Both go as far, so that what lies on what is the same as at rest."""
    retreat, rest = retreat
    vertices, _ = gone_back(retreat, rest, [0.0, forward, sideways])
    moved = (vertices - rest)[np.abs(rest[:, [0, 2]]).max(axis=1) < 12e-3]
    ahead = [0.0, 0.0, max(forward, 0.0) * JAW_MOTION.forward_slide]
    np.testing.assert_allclose(moved, np.broadcast_to(ahead, moved.shape), atol=1e-6)


def test_lower_lip_is_carried_the_upper_one_is_not(retreat):
    retreat, rest = retreat
    middle, upper = np.abs(rest[:, [0, 2]]).max(axis=1) < 4e-3, rest[:, 1] > 0.0
    np.testing.assert_allclose(retreat.carried[middle & upper], 0.0, atol=1e-6)
    np.testing.assert_allclose(retreat.carried[middle & ~upper], 1.0, atol=1e-6)


@pytest.mark.parametrize("depth", [0.1e-3, 0.6e-3, 2e-3])
def test_depth_that_sweeps_have_left_is_seen(depth):
    """The deepest of all points, looked at one by one, is what the ball has it to be."""
    contact, rest = on_ball()
    vertices = pressed(rest, depth)
    assert contact._look.find(vertices, False) == pytest.approx(depth, abs=0.03e-3)


def random_lips(rest, rng):
    """Either lip pushed by up to 4 mm, here and there."""
    upper, places = np.arange(len(rest)) >= SIDE**2, rest[:, [0, 2]]
    vertices = rest.astype(np.float64)
    for _ in range(6):
        centre, width, push = rng.uniform(-10e-3, 10e-3, 2), rng.uniform(2e-3, 4e-3), rng.uniform(-4e-3, 4e-3, 3)
        bump = np.exp(-((places - centre) ** 2).sum(axis=1) / width**2)
        vertices += np.where(upper == (rng.random() < 0.5), bump, 0.0)[:, None] * push
    return vertices.astype(np.float32)


def test_depth_that_sweeps_have_left_in_lips_is_told():
    """A sure look at what sweeps have moved tells of all that a sure look at everything finds too deep."""
    contact, rest = lips()
    look, rng, left = contact._look, np.random.default_rng(1), 0
    for _ in range(600):
        vertices = random_lips(rest, rng)
        look.find(vertices, False)
        look.sweep(vertices)
        told, deep = look.make_sure(vertices, UNFOLDED), look.make_sure(vertices, None)
        assert (told > TOLERATED) == (deep > TOLERATED)
        if deep > TOLERATED:
            assert told == pytest.approx(deep, abs=1e-7)
        left += deep > TOLERATED
    assert left > 5


@pytest.mark.parametrize(
    ("degrees", "gap", "left", "unsure"),
    [(0, -1e-3, -1e-3, False), (20, -1e-3, -1e-3, False), (45, -1e-3, -1e-3, True), (75, -1e-3, 0.0, True),
     (180, -1e-3, 0.0, True), (180, -0.5e-3, -0.5e-3, False), (180, 1e-3, 1e-3, False)],
)  # fmt: skip
def test_what_is_deep_but_does_not_face_what_it_is_behind_is_beside_it(degrees, gap, left, unsure):
    turn = Rotation.from_euler("x", degrees, degrees=True)
    x = turn.apply([[0.0, 0.0, 0.0], [1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0]]).astype(np.float32)
    points, triangles, gaps, unknown = np.zeros(1, np.int32), np.array([[0, 1, 2]]), np.array([gap]), np.zeros(1, bool)
    way_out = np.array([[0.0, 0.0, -1.0]])  # skin looks up where it is not turned
    leave_beside(x, points, points, 1, triangles, np.array([0, 1]), points, 1.0, gaps, way_out, unknown)
    assert (gaps[0], unknown[0]) == (left, unsure)


def test_lips_in_each_other_are_found_but_not_skin_that_is_turned_the_same_way():
    contact, rest = lips()
    vertices = closed(rest, 1e-3)
    assert contact._look.find(vertices.copy(), False) == pytest.approx(1e-3, rel=0.05)
    assert not len(contact._look.unsure_places())
    upper = np.arange(len(rest)) >= SIDE**2
    vertices[upper, 0] *= -1.0  # the same places, the other side up
    assert contact._look.find(vertices, False) < DUBIOUS


def test_lips_are_looked_at_for_sure_around_folds_of_tissue_alone():
    """Where nothing was swept: at all of them only if nobody knows where tissue was folded."""
    contact, rest = lips()
    look, vertices = contact._look, closed(rest, 1e-3)
    near = rest.mean(axis=0, keepdims=True).astype(np.float64)
    depth, told = look.make_sure(vertices, None), []
    assert depth > TOLERATED
    for folds in (UNFOLDED, near + np.array([1.0, 0.0, 0.0]), near, None):
        look.find(rest, False)  # as if the quick look saw nothing
        look._proof.begin(vertices)  # and nothing had moved since
        told.append(look.make_sure(vertices, folds))
    assert max(told[:2]) <= 0.0
    assert told[2:] == pytest.approx([depth, depth], abs=1e-7)


def test_proof_tells_of_lips_what_the_measure_does():
    """By other code, of points that are all vertices of the lips."""
    contact, rest = lips()
    triangles = facing(sheet(0.0)[1])
    measure, rng, deep = PenetrationMeasure(contact.geometry, Poses(), rest, triangles), np.random.default_rng(3), 0
    for _ in range(30):
        vertices = random_lips(rest, rng)
        depth = measure(vertices, AT_REST).lips
        assert max(contact._look.make_sure(vertices, None), 0.0) == pytest.approx(depth, abs=1e-6)
        deep += depth > TOLERATED
    assert deep > 20


def test_who_is_at_the_end_of_a_lip_is_moved_out_of_all_skin_around_to_be_told_whether_it_is_in_tissue():
    """As the measure has it; the lips' own triangles around may be turned away from the rest of the skin."""
    contact, rest = lips()
    proof = contact._look._proof
    skin = facing(sheet(0.0)[1])
    jagged = (rest + np.random.default_rng(5).uniform(-1e-3, 1e-3, rest.shape)).astype(np.float32)
    triangles, fan_starts, fans = proof._points[4:7]
    ends, place = np.flatnonzero(proof._surface[4]), np.empty(3, np.float32)
    moved = []
    for vertex in ends:
        _beside(jagged, vertex, fan_starts, fans, triangles, proof._surface[3], place)
        moved.append((place - jagged[vertex]) / OUT_OF_ITSELF)
    np.testing.assert_allclose(moved, vertex_normals(jagged, skin)[ends], atol=1e-3)
    assert len(moved) > 50


def test_blocks_of_the_grid_never_hide_contact():
    """Gaps with and without the blocks' least distances, CLEAR of everything or not, have the same sign."""
    contact, rest = on_ball()
    rng = np.random.default_rng(4)
    look = contact._look
    for _ in range(5):
        vertices = (rest + rng.uniform(-4e-3, 4e-3, 3)).astype(np.float32)
        look.find(vertices, False)
        gaps, points = look._state[3], look._teeth[0]
        exact = -depths(vertices)[points]
        assert ((gaps < 0.0) == (exact < -0.05e-3))[np.abs(exact) > 0.1e-3].all()
        assert (gaps < exact + 0.1e-3)[exact > 0.0].all()


def test_no_gap_of_lips_is_larger_than_to_the_nearest_vertex_of_the_other():
    """However they are rolled; the way downhill alone ends on the wrong side of a fold."""
    contact, rest = lips()
    tables, downhill = contact.tables, lips()[0]
    downhill._look._around[1][:] = -1
    x, rolled = rest[:, 0], rest.copy()
    upper = np.arange(len(rest)) >= SIDE**2
    angle = np.clip(x / 3e-3, 0.0, 0.9 * np.pi)  # the upper lip rolls up around a roll of 3 mm, the lower one does not
    rolled[upper, 0] = np.where(x > 0.0, 3e-3 * np.sin(angle), x)[upper]
    rolled[upper, 1] += (3e-3 * (1.0 - np.cos(angle)) - 2e-3 * (x > 0.0))[upper]
    sheets = rolled[~upper], rolled[upper]
    other = [sheets[int(vertex < SIDE**2)] for vertex in tables.vertices]
    places = rolled[tables.vertices]
    nearest = np.array([np.linalg.norm(of - place, axis=1).min() for of, place in zip(other, places, strict=True)])
    larger = []
    for effect in (downhill, contact):
        effect._look.find(rolled.copy(), False)
        most = np.clip(nearest, TOLERATED, SEARCHED) + 1e-6
        larger.append(np.count_nonzero(effect._look._state[5] > most))
    assert larger[0] > 10
    assert larger[1] == 0


def test_who_is_behind_a_border_tells_nothing_of_its_neighbours():
    """One point of the upper lip, pulled around the border of the lower one, is outside; its neighbours need not be."""
    contact, rest = lips()
    look, tables, vertices = contact._look, contact.tables, rest.copy()
    upper = np.flatnonzero(tables.vertices >= SIDE**2)
    number = upper[rest[tables.vertices[upper], 0].argmax()]
    border = rest[tables.triangles, 0].max()
    vertices[tables.vertices[number]] = border + 0.4e-3, -1.2e-3, rest[tables.vertices[number], 2]
    gaps = look.gaps(vertices)[1]
    assert gaps[number] == pytest.approx(np.hypot(0.4e-3, 0.7e-3), rel=1e-3)
    np.testing.assert_array_equal(np.intersect1d(upper, np.flatnonzero(look._state[11])), [number])

    beside = np.array([[0.0, 0.0, 0.0], [0.4e-3, 0.0, 0.0]], np.float32)
    for unsure, left, count in ((False, 0.6e-3, 0), (True, 0.0, 1)):
        found, which = np.array([1e-3, 0.0]), np.zeros(2, np.int32)
        arguments = np.arange(2), np.arange(2), np.array([0, 2]), found, np.array([unsure, False]), which
        assert beyond_leaders(beside, *arguments) == count
        assert found[1] == pytest.approx(left, rel=1e-5)
        assert which[:count].tolist() == [1] * count


def test_a_frame_whose_mouth_went_back_says_so_and_by_how_much(walled_model, synthetic_model):
    walled, free = Engine(walled_model), Engine(synthetic_model)
    ours, other = (engine.evaluate({"jaw_open": 1.0}) for engine in (walled, free))
    assert (ours.method, ours.converged) == (other.method + ", went back", True)
    way = np.linalg.norm(ours.vertices - other.vertices, axis=1).max()
    assert way - FARTHEST <= ours.error - other.error <= way + FARTHEST
    ours, other = (engine.evaluate({"jaw_open": 0.01}) for engine in (walled, free))
    assert (ours.method, ours.error) == (other.method, other.error)


@pytest.mark.parametrize(("opened", "needless"), [(1.0, 0), (0.01, 1)])
def test_gauntlet_sees_a_mouth_that_goes_back_without_need(walled_model, monkeypatch, opened, needless):
    for limit in ("SHALLOW", "TOLERATED"):  # so that it always goes back
        monkeypatch.setattr(f"risorius.effects.contact.{limit}", -2.0)
    judge = Judge(Bench(walled_model))
    judge.take(Ask({"jaw_open": opened}))
    assert (judge.went_back, judge.broken["needed"]) == (1, needless)


def test_contact_that_met_numbers_that_are_none_is_as_new_when_restarted():
    contact, rest = lips()
    new = lips()[0]
    broken = rest.copy()
    broken[::7] = np.nan
    with np.errstate(invalid="ignore"):
        contact.finish(AT_REST, broken, folds=None)
    contact.restart()
    for folds in (UNFOLDED, None):
        vertices, expected = closed(rest, 1e-3), closed(rest, 1e-3)
        contact.finish(AT_REST, vertices, folds)
        new.finish(AT_REST, expected, folds)
        np.testing.assert_array_equal(vertices, expected)
