"""Contact with bones: distances against solids known in closed form, forces against theory, rest free of forces."""

from dataclasses import replace

import numpy as np
import pytest

from risorius.errors import InputError
from risorius.jaw import JawMotion
from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy.anatomy import Surface
from risorius_offline.anatomy.surface import as_triangles, boundary_faces
from risorius_offline.discretisation import CellBlock
from risorius_offline.effects.bone_contact import BoneContact
from risorius_offline.effects.signed_distance import SignedDistance
from risorius_offline.effects.triangle_distance import signed_distances
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.full_model import FullModel
from tests.offline.meshes import box, box_hexahedra
from tests.offline.models import block_anatomy

TISSUE = Yeoh.neo_hookean(15e3, 0.3)
TOLERANCE, PRESSURE = 3e-4, 50e3
RADIUS = 0.02


def box_surface(low, high):
    """The twelve triangles of a box between two corners."""
    points, cells = box_hexahedra((1, 1, 1), tuple(np.subtract(high, low)))
    block = CellBlock("hexahedron", cells, np.zeros(1, dtype=np.int64))
    return Surface(points + low, as_triangles(boundary_faces([block]), points))


def sphere_surface(radius, centre=(0.0, 0.0, 0.0), cells=48):
    """A cube's surface blown up to a sphere."""
    points, hexahedra = box_hexahedra((cells,) * 3, (2.0,) * 3)
    block = CellBlock("hexahedron", hexahedra, np.zeros(len(hexahedra), dtype=np.int64))
    triangles = as_triangles(boundary_faces([block]), points)
    used, triangles = np.unique(triangles, return_inverse=True)
    directions = np.tan((points[used] - 1.0) * np.pi / 4)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return Surface(radius * directions + centre, triangles.reshape(-1, 3))


def box_distance(points, half):
    outside = np.abs(points) - half
    return np.linalg.norm(np.maximum(outside, 0.0), axis=-1) + np.minimum(outside.max(axis=-1), 0.0)


def grid(low, spacing, shape):
    return low + spacing * np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)


def test_distances_to_a_box_are_exact_on_faces_edges_and_corners_on_both_sides():
    half, band, spacing, shape = np.array([0.010, 0.008, 0.013]), 3e-3, 1.1e-3, (26, 22, 32)
    low = -0.5 * spacing * (np.array(shape) - 1) + 1e-5
    found = signed_distances(box_surface(-half, half), low, spacing, shape, band)
    exact = np.clip(box_distance(grid(low, spacing, shape), half), -band, band)
    assert (exact == -band).any()
    assert (exact == band).any()
    np.testing.assert_allclose(found, exact, atol=1e-15)


def test_surface_turned_inside_out_has_the_same_distances():
    solid = box_surface([-0.01] * 3, [0.01] * 3)
    flipped = Surface(solid.points, solid.triangles[:, ::-1])
    arguments = (np.full(3, -0.0151), 1e-3, (31, 31, 31), 3e-3)
    expected = signed_distances(solid, *arguments)
    np.testing.assert_allclose(signed_distances(flipped, *arguments), expected, atol=1e-15)


def test_beyond_the_border_of_an_open_surface_is_outside():
    half = 0.01
    solid = box_surface([-half] * 3, [half] * 3)
    lid = (solid.points[solid.triangles, 2] == half).all(axis=1)
    low, spacing, shape, band = np.full(3, -0.0151), 1e-3, (31, 31, 31), 3e-3
    found = signed_distances(Surface(solid.points, solid.triangles[~lid]), low, spacing, shape, band)
    x, y, z = np.moveaxis(grid(low, spacing, shape), -1, 0)
    above, below = z > half, z < half - 2 * band
    assert (found[above] > 0.0).all()
    exact = np.clip(box_distance(np.stack([x, y, z], axis=-1), half), -band, band)
    near = below & (exact > -band)
    np.testing.assert_allclose(found[near], exact[near], atol=1e-15)


def test_triangles_wound_differently_are_refused_with_their_edge():
    solid = box_surface([-0.01] * 3, [0.01] * 3)
    triangles = solid.triangles.copy()
    triangles[0] = triangles[0, ::-1]
    anatomy = replace(tissue_block(), bones={"maxilla": Surface(solid.points, triangles)})
    with pytest.raises(InputError, match=r"bone 'maxilla': 2 triangles run from point \d+ to point \d+; wind"):
        BoneContact(anatomy)


def shell_points(count=400):
    """Points from 2 mm inside to 2 mm outside of the sphere."""
    random = np.random.default_rng(1)
    directions = random.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return directions, RADIUS + random.uniform(-2e-3, 2e-3, count)


def test_spline_of_a_sphere_errs_by_the_second_order_term_and_has_its_normals():
    directions, r = shell_points()
    surface = sphere_surface(RADIUS)
    errors = []
    for spacing in (2e-3, 1e-3):
        distance = SignedDistance.of(surface, spacing=spacing)
        errors.append(distance.values(r[:, None] * directions) - (r - RADIUS))
        gradients, _ = distance.derivatives(r[:, None] * directions)
        np.testing.assert_allclose(gradients, directions, atol=0.4 * (spacing / RADIUS) ** 2 + 3e-3)
    np.testing.assert_allclose(errors[0], 2e-3**2 / (3 * r), atol=1.2e-5)
    # Flat triangles lie up to 5 micrometres inside the sphere, whatever the spacing: the difference is free of that.
    np.testing.assert_allclose(errors[0] - errors[1], (2e-3**2 - 1e-3**2) / (3 * r), rtol=0.05)


def test_spline_is_exact_beside_a_face_on_both_sides():
    distance = SignedDistance.of(box_surface([-0.03] * 3, [0.03] * 3))
    offset = np.linspace(-2.9e-3, 2.9e-3, 31)
    points = np.column_stack([np.full(31, 0.0113), 0.03 + offset, np.full(31, -0.0071)])
    gradients, hessians = distance.derivatives(points)
    np.testing.assert_allclose(distance.values(points), offset, atol=1e-15)
    np.testing.assert_allclose(gradients, np.tile([0.0, 1.0, 0.0], (31, 1)), atol=1e-12)
    np.testing.assert_allclose(hessians, 0.0, atol=1e-8)


def test_distances_to_a_surface_that_is_its_own_mirror_image_are_too():
    distance = SignedDistance.of(box_surface([-0.0107] * 3, [0.0107] * 3))
    points = np.random.default_rng(5).uniform(-0.014, 0.014, (200, 3))
    for axis in range(3):
        mirror = np.where(np.arange(3) == axis, -1.0, 1.0)
        np.testing.assert_allclose(distance.values(points * mirror), distance.values(points), atol=1e-15)


def test_beyond_the_grid_is_far():
    distance = SignedDistance.of(box_surface([-0.01] * 3, [0.01] * 3))
    far = np.array([[0.5, 0.0, 0.0], [0.0, -0.03, 0.0]])
    np.testing.assert_array_equal(distance.values(far), distance.band)
    np.testing.assert_array_equal(distance.derivatives(far)[0], 0.0)


def tissue_block():
    """A 20 mm cube of tissue above the plane z = 0, fixed at its top; the jaw moves in all its ways."""
    points, cells = box("hexahedron", (4, 4, 4))
    anatomy = block_anatomy(points, cells, TISSUE, fixed=np.isclose(points[:, 2], 0.02))
    return replace(anatomy, jaw_motion=JawMotion((0.01, 0.02, -0.05), 0.3, 0.002, 0.003, 0.004))


def touched_block():
    """The cube with a round jaw beneath and a tooth of the maxilla at its side, and a state that touches both."""
    jaw = sphere_surface(0.008, (0.004, 0.006, -0.0082), 16)
    tooth = box_surface((-0.006, 0.004, 0.004), (-0.0004, 0.016, 0.016))
    contact = BoneContact(replace(tissue_block(), bones={"jaw": jaw, "maxilla": tooth}))
    contact.set_parameters(np.array([0.1, 0.4, -0.3]))
    u = 4e-4 * np.random.default_rng(2).normal(size=(125, 3)) - [5e-4, 0.0, 2e-3]
    return contact, u


def test_forces_are_the_derivative_of_the_energy():
    contact, u = touched_block()
    direction = np.random.default_rng(3).normal(size=u.shape)
    h = 1e-8
    difference = (contact.energy(u + h * direction) - contact.energy(u - h * direction)) / (2 * h)
    forces = np.zeros_like(u)
    energy = contact.add_forces(u, forces)
    assert len(contact.second_derivatives(u, project=False).nodes) >= 10
    assert energy == pytest.approx(contact.energy(u), rel=1e-14)
    assert (forces * direction).sum() == pytest.approx(difference, rel=1e-6)


def test_second_derivatives_are_those_of_the_forces():
    contact, u = touched_block()
    direction = np.random.default_rng(4).normal(size=u.shape)
    h = 1e-8
    plus, minus = np.zeros_like(u), np.zeros_like(u)
    contact.add_forces(u + h * direction, plus)
    contact.add_forces(u - h * direction, minus)
    difference = (plus - minus) / (2 * h)
    blocks = contact.second_derivatives(u, project=False)
    product = np.zeros_like(u)
    np.add.at(product, blocks.nodes[:, 0], np.einsum("kij,kj->ki", blocks.matrices, direction[blocks.nodes[:, 0]]))
    assert np.linalg.norm(product - difference) < 1e-7 * np.linalg.norm(difference)


def test_projected_blocks_have_no_negative_eigenvalue_and_keep_the_others():
    contact, u = touched_block()
    true = np.linalg.eigvalsh(contact.second_derivatives(u, project=False).matrices)
    projected = np.linalg.eigvalsh(contact.second_derivatives(u, project=True).matrices)
    assert true.min() < -1.0
    np.testing.assert_allclose(projected, np.maximum(true, 0.0), atol=1e-9 * true.max())


def test_nodes_carried_along_with_the_jaw_keep_their_gaps_and_forces_turn_along():
    jaw = sphere_surface(0.008, (0.004, 0.006, -0.0082), 16)
    anatomy = replace(tissue_block(), bones={"jaw": jaw})
    contact, motion = BoneContact(anatomy), anatomy.jaw_motion
    local = 4e-4 * np.random.default_rng(5).normal(size=anatomy.points.shape) - [0.0, 0.0, 5e-4]
    x = anatomy.points + local
    before, after = np.zeros_like(x), np.zeros_like(x)
    gaps, energy = contact.gaps(local), contact.add_forces(local, before)
    weights = np.array([0.7, 0.5, -1.0])
    contact.set_parameters(weights)
    carried = local + np.tensordot(motion.lift_coordinates(weights), motion.unit_motions(x), axes=1)
    angle = 0.7 * motion.opening_angle
    cosine, sine = np.cos(angle), np.sin(angle)
    rotation = np.array([[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]])
    assert energy > 0.0
    np.testing.assert_allclose(contact.gaps(carried), gaps, atol=1e-15)
    assert contact.add_forces(carried, after) == pytest.approx(energy, rel=1e-9)
    np.testing.assert_allclose(after, before @ rotation.T, atol=1e-9 * np.abs(before).max())


def test_force_is_pressure_times_area_along_the_normal_of_the_bone_without_friction():
    floor = box_surface((-0.03, -0.03, -0.02), (0.05, 0.05, -1e-3))
    anatomy = replace(tissue_block(), bones={"maxilla": floor})
    contact = BoneContact(anatomy)
    u = np.zeros_like(anatomy.points)
    u[:] = [2e-3, -1e-3, -0.9e-3]  # sliding, and down to a gap of 0.1 mm
    forces = np.zeros_like(u)
    contact.add_forces(u, forces)
    pressure = PRESSURE * ((TOLERANCE - 1e-4) / TOLERANCE) ** 2
    below = np.isclose(anatomy.points[contact.nodes, 2], 0.0)
    np.testing.assert_allclose(forces[:, :2], 0.0, atol=1e-12)
    np.testing.assert_allclose(contact.gaps(u)[below], 1e-4, atol=1e-15)
    np.testing.assert_allclose(-forces[contact.nodes, 2], np.where(below, pressure * contact.areas, 0.0), rtol=1e-9)


def test_a_state_is_admitted_up_to_two_millimetres_inside_a_bone():
    floor = box_surface((-0.03, -0.03, -0.02), (0.05, 0.05, -1e-3))
    contact = BoneContact(replace(tissue_block(), bones={"maxilla": floor}))
    u = np.zeros((125, 3))
    for depth, admitted in ((1.9e-3, True), (2.1e-3, False)):
        u[:, 2] = -1e-3 - depth
        assert contact.admits(u) == admitted


def test_nodes_share_the_area_of_the_boundary():
    contact = BoneContact(replace(tissue_block(), bones={"maxilla": box_surface([-0.01] * 3, [-0.005] * 3)}))
    assert contact.areas.max() == pytest.approx(0.005**2)
    edges_at_the_top = 16 * 0.005**2 / 2  # the fixed nodes there have half of the uppermost row of faces
    assert contact.areas.sum() == pytest.approx(5 * 0.02**2 - edges_at_the_top)


def test_tissue_that_cuts_the_bone_at_rest_is_free_of_forces_there_and_resists_further_approach():
    floor = box_surface((-0.03, -0.03, -0.02), (0.05, 0.05, 5e-4))
    anatomy = replace(tissue_block(), bones={"maxilla": floor})
    contact = BoneContact(anatomy)
    u = np.zeros_like(anatomy.points)
    inner = np.flatnonzero(np.isclose(contact.areas, 0.005**2) & np.isclose(anatomy.points[contact.nodes, 2], 0.0))
    assert contact.energy(u) == 0.0
    assert contact.gaps(u).min() == TOLERANCE
    u[:, 2] = -TOLERANCE
    forces = np.zeros_like(u)
    contact.add_forces(u, forces)
    np.testing.assert_allclose(-forces[contact.nodes[inner], 2], PRESSURE * 0.005**2, rtol=1e-9)


def test_no_step_takes_a_node_deeper_than_2_mm_into_a_bone():
    floor = box_surface((-0.03, -0.03, -0.02), (0.05, 0.05, -1e-3))
    contact = BoneContact(replace(tissue_block(), bones={"maxilla": floor}))
    u = np.zeros((125, 3))
    down = np.tile([0.0, 0.0, -0.012], (125, 1))
    assert contact.largest_step(u, down) == pytest.approx(3.0 / 12.0)
    assert contact.largest_step(u, 0.1 * down) == 1.0


def test_step_that_goes_along_with_the_jaw_is_not_cut_but_one_over_the_jaw_is():
    anatomy = tissue_block()
    top = np.isclose(anatomy.points[:, 2], 0.02)
    jaw = {"jaw": sphere_surface(0.008, (0.004, 0.006, -0.0082), 16)}
    contact, motion = BoneContact(replace(anatomy, skull=~np.ones(125, bool), jaw=top, bones=jaw)), anatomy.jaw_motion
    opening = np.array([0.5, 0.0, 1.0])
    contact.set_parameters(opening)
    change = motion.lift_coordinates(np.array([1.0, 1.0, 0.0])) - motion.lift_coordinates(opening)
    u, direction = (
        np.tensordot(lifts, motion.unit_motions(anatomy.points), axes=1)
        for lifts in (motion.lift_coordinates(opening), change)
    )
    assert contact.largest_step(u, direction) == 1.0
    direction[top] = 0.0
    assert contact.largest_step(u, direction) < 0.5


def pressed(anatomy, surface, depth, tolerance=TOLERANCE):
    """Equilibrium of tissue fixed at z = 0 into which a jaw of that surface goes down; model and contact."""
    motion = JawMotion((0.0, 0.0, 0.0), 0.0, 0.0, -depth, 0.0)
    contact = BoneContact(replace(anatomy, jaw_motion=motion, bones={"jaw": surface}), tolerance)
    model = FullModel(replace(anatomy, jaw_motion=motion), [contact])
    return EquilibriumSolver(model, tolerance=1e-8).solve(np.array([0.0, 1.0, 0.0])), model, contact


def test_flat_bone_compresses_a_wide_layer_as_in_uniaxial_strain():
    """In the middle the pressure is that of the energy at the stretch found, and the gap is d (1 - sqrt(p / p0))."""
    height = 0.003
    points, cells = box("hexahedron", (8, 8, 2), (0.06, 0.06, height))
    plate = box_surface((-0.02, -0.02, height + TOLERANCE), (0.08, 0.08, height + 0.01))
    found, model, contact = pressed(block_anatomy(points, cells, TISSUE), plate, 5e-4)
    middle = np.linalg.norm(points - [0.03, 0.03, height], axis=1).argmin()
    stretch = 1.0 + found.u[middle, 2] / height
    pressure = -(2 * TISSUE.c10 * (stretch - 1 / stretch) + TISSUE.lame * np.log(stretch) / stretch)
    gap = contact.gaps(found.u)[contact.nodes == middle][0]
    forces = np.zeros_like(found.u)
    contact.add_forces(found.u, forces)
    reactions = model.forces(found.u)[2]
    assert found.u[middle, 2] + 5e-4 == pytest.approx(TOLERANCE - gap, abs=1e-12)
    assert 0.0 < gap < TOLERANCE
    assert gap == pytest.approx(TOLERANCE * (1.0 - np.sqrt(pressure / PRESSURE)), rel=1e-3)
    assert forces[:, 2].sum() == pytest.approx(reactions[points[:, 2] == 0.0, 2].sum(), rel=1e-6)


def test_sphere_on_a_layer_follows_hertz_with_the_correction_for_its_thickness():
    """Hertz's law times the series of a layer bonded to a rigid base (Dimitriadis et al. 2002).

    At 0.12 mm, where strains are small; the excess, 3 %, falls with the depth.
    """
    radius, height, poisson, tolerance = 0.05, 0.01, 0.3, 3e-5
    graded = np.array([0.0, 6.0, 10.5, 13.5, 15.3, *np.linspace(16.4, 20.0, 6)]) * 1e-3
    graded = np.concatenate([graded, 0.04 - graded[-2::-1]])
    depth = np.array([0.0, 2.5, 5.0, 7.0, 8.2, 9.1, 10.0]) * 1e-3
    sides = (len(graded) - 1, len(graded) - 1, len(depth) - 1)
    unit, hexahedra = box_hexahedra(sides, sides)
    points = np.stack([axis[np.rint(unit[:, k]).astype(int)] for k, axis in enumerate((graded, graded, depth))], axis=1)
    cells = CellBlock("hexahedron", hexahedra, np.zeros(len(hexahedra), dtype=np.int64))
    sphere = sphere_surface(radius, (0.02, 0.02, height + radius + tolerance))
    found, _, contact = pressed(block_anatomy(points, cells, TISSUE), sphere, 1.5e-4, tolerance)
    forces = np.zeros_like(found.u)
    contact.add_forces(found.u, forces)
    indentation = -found.u[np.linalg.norm(points - [0.02, 0.02, height], axis=1).argmin(), 2]
    a = -(1.2876 - 1.4678 * poisson + 1.3442 * poisson**2) / (1 - poisson)
    b = (0.6387 - 1.0277 * poisson + 1.5164 * poisson**2) / (1 - poisson)
    x = np.sqrt(radius * indentation) / height
    series = 1 - 2 * a / np.pi * x + 4 * (a / np.pi * x) ** 2
    series -= 8 / np.pi**3 * (a**3 + 4 * np.pi**2 / 15 * b) * x**3
    series += 16 * a / np.pi**4 * (a**3 + 3 * np.pi**2 / 5 * b) * x**4
    hertz = 4 / 3 * 15e3 / (1 - poisson**2) * np.sqrt(radius) * indentation**1.5
    assert forces[:, 2].sum() == pytest.approx(hertz * series, rel=0.05)


def ridged_bone(height):
    """A 40 mm thick bone whose top at z = 0 has ridges along y, 5 mm apart."""
    points, cells = box("hexahedron", (24, 1, 1), (0.06, 0.06, 0.04))
    ridge = np.isclose(points[:, 2], 0.04) & (np.rint(points[:, 0] / 2.5e-3) % 2 == 1)
    points = points - [0.02, 0.02, 0.04]
    points[ridge, 2] += height
    return Surface(points, as_triangles(boundary_faces([cells]), points))


def test_ridges_finer_than_the_mesh_do_not_hold_a_node_that_slides():
    """Nodes and ridges are 5 mm apart: what holds one node holds all of them."""
    bone = ridged_bone(3e-4)
    anatomy = replace(tissue_block(), bones={"maxilla": bone})
    contact = BoneContact(anatomy)
    slid = np.linspace(0.0, 5e-3, 41)
    node = np.flatnonzero(np.isclose(anatomy.points[contact.nodes], [0.01, 0.01, 0.0]).all(axis=1))[0]
    gaps = [contact.gaps(np.full((125, 3), [s, 0.0, -1e-4]))[node] for s in slid]
    bare = SignedDistance.of(bone).values(np.column_stack([0.01 + slid, np.full(41, 0.01), np.full(41, 2e-4)]))
    assert np.ptp(bare) > 1e-4
    assert np.ptp(gaps) < 0.1 * np.ptp(bare)


def test_a_bone_thinner_than_the_mesh_stays_where_it_is():
    plate = box_surface((-0.03, -0.03, -5e-3), (0.05, 0.05, -1e-3))
    anatomy = replace(tissue_block(), bones={"maxilla": plate})
    contact = BoneContact(anatomy)
    below = np.isclose(anatomy.points[contact.nodes, 2], 0.0)
    u = np.full((125, 3), [0.0, 0.0, -0.9e-3])
    np.testing.assert_allclose(contact.gaps(u)[below], 1e-4, atol=1e-5)


def test_published_face_at_rest_is_free_of_contact_forces_although_it_cuts_its_bones(published_face):
    contact = BoneContact(published_face)
    u = np.zeros_like(published_face.points)
    forces = np.zeros_like(u)
    contact.set_parameters(np.zeros(len(published_face.inputs.parameters)))
    nearest = np.min(
        [SignedDistance.of(b).values(published_face.points) for b in published_face.bones.values()], axis=0
    )
    assert (nearest[contact.nodes] < 0.0).sum() > 20
    assert contact.add_forces(u, forces) == 0.0
    assert not forces.any()
