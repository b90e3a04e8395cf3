"""The built-in head at rest: distances, depths, quality of its cells, symmetry, what is seen."""

from collections import Counter

import numpy as np
import pytest

from risorius.errors import InputError
from risorius.expressions import EMOTIONS
from risorius.penetration import PenetrationMeasure
from risorius_offline.contact_choice import ContactChoice
from risorius_offline.contact_geometry import contact_geometry
from risorius_offline.discretisation import Discretisation
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.effects.signed_distance import SignedDistance
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.head.head import built_in_head
from risorius_offline.head.proportions import ADULT, NORMS
from risorius_offline.head.quality import scaled_jacobians
from risorius_offline.head.reshape import MILLIMETRES, SELLION
from risorius_offline.head.skin import SKIN
from risorius_offline.head.warp import Warp
from risorius_offline.muscles.fibres import volume_positions
from tests.full_head import MUSCLES
from tests.offline.head_measures import distances, level, openings, soft_tissue_depths, triangles

MIDDLE_OF_THE_BROW = (28.0, 38.0, 87.0)
CHIN = (0.0, -78.0, 94.0)
MIRROR = np.array([-1.0, 1.0, 1.0])


def test_right_prism_on_an_even_triangle_has_scaled_jacobians_of_one():
    even = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, np.sqrt(0.75)]])
    points = np.vstack([np.column_stack([even, np.full(3, height)]) for height in (0.0, 0.3)])
    np.testing.assert_allclose(scaled_jacobians(points, np.arange(6)[None]), 1.0, atol=1e-14)
    np.testing.assert_allclose(scaled_jacobians(points * MIRROR, np.arange(6)[None]), -1.0, atol=1e-14)


@pytest.mark.parametrize("name", NORMS)
def test_distance_between_landmarks_is_that_of_an_adult(sculpted_head, adult_head, name):
    assert distances(sculpted_head, adult_head)[name] == pytest.approx(NORMS[name].mean, rel=0.08)


def test_soft_tissue_is_as_deep_square_to_the_bone_as_published(sculpted_head, adult_head):
    depths = soft_tissue_depths(sculpted_head, adult_head)
    off = {name: measured / published - 1.0 for name, (published, measured) in depths.items()}
    assert len(off) == 17
    assert max(map(abs, off.values())) < 0.3, off


def test_no_cell_is_bad_and_one_in_a_hundred_poor(adult_head):
    assert_sound(adult_head)


@pytest.mark.slow
@pytest.mark.parametrize("size", ["standard", "fine"])
def test_no_cell_of_a_larger_size_is_bad_either(size):
    assert_sound(built_in_head(size))


@pytest.mark.slow
def test_two_builds_are_the_same_to_the_last_bit(adult_head):
    assert built_in_head("draft").checksum() == adult_head.checksum()


def test_unknown_size_is_named_with_those_that_there_are():
    with pytest.raises(InputError, match=r"size 'huge'.*draft, standard, fine"):
        built_in_head("huge")


def test_nodes_cells_and_what_holds_them_are_mirror_images(adult_head):
    other = mirror_nodes(adult_head.points)
    assert (other[other] == np.arange(len(other))).all()
    np.testing.assert_array_equal(adult_head.skull[other], adult_head.skull)
    np.testing.assert_array_equal(adult_head.jaw[other], adult_head.jaw)
    np.testing.assert_array_equal(np.array([0, 2, 1])[adult_head.lids[other]], adult_head.lids)
    faces = triangles(adult_head)
    across = other[: len(level(adult_head, 0))]
    assert faces_of(across[faces][:, ::-1]) == faces_of(faces)
    left, right = (np.array(centre) for centre in adult_head.lid_motion.centres)
    np.testing.assert_array_equal(left * MIRROR, right)
    assert adult_head.jaw_motion.condyle_centre[0] == 0.0


def test_frenula_hold_the_lips_at_the_midline_alone_each_to_the_bone_of_its_teeth(sculpted_head):
    deep = MILLIMETRES * level(sculpted_head, 0) + SELLION
    skull, jaw = (held[: len(deep)] for held in (sculpted_head.skull, sculpted_head.jaw))
    near = (deep[:, 2] > 75.0) & (np.abs(deep[:, 0]) < 5.0)
    at_midline = deep[:, 0] == 0.0
    upper, lower = ((deep[:, 1] > low) & (deep[:, 1] < high) & near for low, high in ((-33.0, -26.0), (-61.0, -56.5)))
    assert (upper & at_midline).any()
    assert (lower & at_midline).any()
    np.testing.assert_array_equal(skull[upper], at_midline[upper])
    np.testing.assert_array_equal(jaw[lower], at_midline[lower])


def test_mentalis_raises_the_chin_and_not_its_own_origin(adult_head):
    _, up, _ = moved(adult_head, {"AU17": 1.0})[place_on_skin(adult_head, CHIN)]
    assert up > 5e-3


def test_muscles_are_mirror_images(adult_head):
    fibres = {muscle.name: muscle.fibres for muscle in adult_head.muscles}
    for name in MUSCLES:
        for left, right in zip(fibres[f"{name}_L"].lines, fibres[f"{name}_R"].lines, strict=True):
            np.testing.assert_array_equal(left * MIRROR, right)


def test_every_muscle_is_there_on_both_sides_with_tissue(adult_head):
    discretisation = Discretisation(adult_head.points, adult_head.cells)
    with_tissue = {m.name for m in adult_head.muscles if len(m.fibres.field(discretisation).points)}
    assert with_tissue == {f"{name}_{side}" for name in MUSCLES for side in "LR"}


def test_visible_triangles_face_outwards_as_the_sculpture_does(sculpted_head):
    surface = sculpted_head.surface
    on_skin = np.arange(len(sculpted_head.points)) >= sculpted_head.skin.min()
    outer = (surface.weights @ on_skin > 1.0 - 1e-9)[surface.triangles].all(axis=1)
    corners = (MILLIMETRES * surface.points + SELLION)[surface.triangles[outer]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outward = SKIN.gradient(corners.mean(axis=1))
    cosine = (normals * outward).sum(1) / np.linalg.norm(normals, axis=1) / np.linalg.norm(outward, axis=1)
    assert cosine.min() > 0.0


@pytest.mark.parametrize("side", ["left", "right"])
def test_eyeball_is_a_sphere_about_the_centre_that_the_lid_turns_about(adult_head, side):
    centre = adult_head.lid_motion.centres[side == "right"]
    for points in (adult_head.bones[f"{side}_eyeball"].points, adult_head.companions[f"eyeball_{side}"].points):
        away = np.linalg.norm(points - centre, axis=1)
        assert np.ptp(away) < 1e-12


@pytest.mark.parametrize("name", ["cranium", "jaw"])
def test_bone_is_its_own_mirror_image(adult_head, name):
    bone = adult_head.bones[name]
    other = mirror_nodes(bone.points)
    assert faces_of(other[bone.triangles][:, ::-1]) == faces_of(bone.triangles)


def test_lips_do_not_get_behind_the_teeth_through_the_slit_between_them(adult_head):
    behind = level(adult_head, 0)[openings(adult_head)[0]] - [0.0, 0.0, 3e-3]
    behind = behind[np.abs(behind[:, 0]) < 0.015]
    depths = [SignedDistance.of(adult_head.bones[name]).values(behind) for name in ("cranium", "jaw")]
    assert len(behind) > 10
    assert np.min(depths, axis=0).max() < -1e-3


def test_teeth_reach_past_each_other(adult_head):
    heights = {name: adult_head.bones[name].points for name in ("cranium", "jaw")}
    for name, points in heights.items():
        heights[name] = points[(np.abs(points[:, 0]) < 0.03) & (points[:, 2] > -0.04), 1]
    assert heights["jaw"].max() - heights["cranium"].min() > 8e-3


@pytest.mark.parametrize("contact", [ContactChoice.NONE, ContactChoice.LIPS])
def test_smile_is_its_own_mirror_image(adult_head, contact):
    solver = EquilibriumSolver(EffectChoice(contact).model(adult_head))
    smile = solver.solve(adult_head.inputs.to_parameters(adult_head.inputs.weights({"AU12": 1.0}))).u
    np.testing.assert_allclose(smile[mirror_nodes(adult_head.points)] * MIRROR, smile, atol=1e-9)


def depth_in_teeth(head, parameters):
    """Depth in metres of the visible skin in teeth at an equilibrium of the full model."""
    solver = EquilibriumSolver(EffectChoice(ContactChoice.LIPS).model(head))
    surface, poses = head.visible_surface, head.poses
    vertices = surface.points + surface.weights @ solver.solve(parameters).u
    measure = PenetrationMeasure(contact_geometry(head), poses, surface.points, surface.triangles)
    return measure(vertices, poses.lift_coordinates(parameters[len(head.muscles) :])).teeth


@pytest.mark.parametrize("unit", ["AU18", "AU28"])
def test_skin_that_slides_on_bones_stays_out_of_the_teeth_that_are_seen(adult_head, unit):
    parameters = adult_head.inputs.to_parameters(adult_head.inputs.weights({unit: 1.0}))
    assert depth_in_teeth(adult_head, parameters) < 0.3e-3


def test_upper_lip_that_curls_beneath_the_teeth_stays_out_of_them(adult_head):
    """By nodes on bones alone it gets 0.41 mm in."""
    names, pulled = adult_head.inputs.parameters, ("orbicularis_oris_marginalis_superior", "platysma")
    parameters = np.array([float(name.startswith(pulled)) + 0.5 * (name == "jaw_open") for name in names])
    assert depth_in_teeth(adult_head, parameters) < 0.1e-3


def test_fear_raises_brows_and_draws_them_together(adult_head):
    fear = next(emotion for emotion in EMOTIONS if emotion.name == "fear")
    brows = {name: weight for name, weight in fear.weights.items() if name in ("AU1", "AU2", "AU4")}
    out, up, _ = moved(adult_head, brows)[place_on_skin(adult_head, MIDDLE_OF_THE_BROW)]
    assert len(brows) == 3
    assert up > 2e-3
    assert out < -3e-3


@pytest.mark.parametrize("unit", ["AU2_L", "AU6_L"])
def test_unit_about_the_left_eye_leaves_the_right_half_still(adult_head, unit):
    length = np.linalg.norm(moved(adult_head, {unit: 1.0}), axis=1)
    assert length[adult_head.surface.points[:, 0] < -0.01].max() < 0.05 * length.max()


@pytest.mark.slow
def test_jaw_opens_all_the_way_with_contact(adult_head):
    solver = EquilibriumSolver(EffectChoice(ContactChoice.LIPS).model(adult_head))
    opened = adult_head.inputs.to_parameters(adult_head.inputs.weights({"AU27": 1.0}))
    assert solver.solve(opened).report.stable


@pytest.mark.parametrize("side", ["L", "R"])
def test_no_muscle_has_tissue_beyond_the_midline(adult_head, side):
    discretisation = Discretisation(adult_head.points, adult_head.cells)
    positions = volume_positions(discretisation)[:, 0] * (1.0 if side == "L" else -1.0)
    for muscle in adult_head.muscles:
        if muscle.name.endswith(side):
            assert positions[muscle.fibres.field(discretisation).points].min() >= 0.0, muscle.name


def moved(head, weights):
    """Displacement (v, 3) of the visible skin, with contact on bones."""
    solver = EquilibriumSolver(EffectChoice(ContactChoice.BONES).model(head))
    return head.surface.weights @ solver.solve(head.inputs.to_parameters(head.inputs.weights(weights))).u


def place_on_skin(head, place):
    """Number of the visible point nearest to a place of the sculpture, millimetres."""
    wanted = (Warp(ADULT)(np.array([place])) - SELLION) / MILLIMETRES
    return np.linalg.norm(head.surface.points - wanted, axis=1).argmin()


def assert_sound(head):
    worst = scaled_jacobians(head.points, head.cells[0].connectivity).min(axis=1)
    assert worst.min() >= 0.05
    assert np.percentile(worst, 1.0) >= 0.2


def mirror_nodes(points):
    """Number (n,) of the node that is exactly the mirror image."""
    places = {tuple(point): number for number, point in enumerate(points.tolist())}
    return np.array([places[-x, y, z] for x, y, z in points.tolist()])


def faces_of(faces):
    """Triangles as a multiset, whichever corner is first."""
    first = faces.argmin(axis=1)
    return Counter(tuple(np.roll(face, -k)) for face, k in zip(faces, first, strict=True))
