"""Strain, stress, force and work against closed forms, and the files that hold them."""

from dataclasses import replace

import meshio
import numpy as np
import pytest

from risorius.errors import SolverError
from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy.surface import as_triangles, boundary_faces
from risorius_offline.discretisation import CellBlock
from risorius_offline.effects import DeadLoad
from risorius_offline.elements import ELEMENTS
from risorius_offline.equilibrium import Equilibrium, EquilibriumSolver
from risorius_offline.exporters.vtu import write_skin, write_tissue
from risorius_offline.full_model import FullModel
from risorius_offline.muscles.loads import ActiveStress, ForceDensity
from risorius_offline.muscles.muscle import Muscle
from risorius_offline.muscles.polyline_fibres import PolylineFibres
from risorius_offline.quantities import SkinState, bone_reactions, muscle_state, skin_state
from tests.offline.meshes import box, box_hexahedra, wedges
from tests.offline.models import block_anatomy, muscle_block

TISSUE = Yeoh(2500.0, 1175.0, 250e3)
STIFF = Yeoh(9000.0, 400.0, 800e3)
TURN = np.linalg.qr(np.array([[2.0, 1.0, 0.0], [-1.0, 2.0, 1.0], [0.5, 0.0, 1.0]]))[0]
TURN *= np.sign(np.linalg.det(TURN))
UNIAXIAL = np.diag([1.3, 0.9, 0.9])
BIAXIAL = np.diag([1.2, 1.1, 0.8])
SHEAR = np.array([[1.0, 0.4, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])


def displaced(points, F):
    return np.ascontiguousarray(points @ (F - np.eye(3)).T)


def theory(material, F):
    """sigma = (2 psi' F F^T - 2 c10 I + lam ln J I) / J, psi' = c10 + 2 c20 (I1 - 3)."""
    left, jacobian = F @ F.T, np.linalg.det(F)
    slope = material.c10 + 2.0 * material.c20 * (np.trace(left) - 3.0)
    return (2.0 * slope * left + (material.lame * np.log(jacobian) - 2.0 * material.c10) * np.eye(3)) / jacobian


def top_of(skin, points):
    """Numbers of the skin triangles on the face of the block with the largest z."""
    return np.flatnonzero(np.isclose(points[skin.triangles][:, :, 2], points[:, 2].max()).all(axis=1))


@pytest.mark.parametrize("cell_type", sorted(ELEMENTS))
@pytest.mark.parametrize("F", [UNIAXIAL, BIAXIAL, SHEAR], ids=["uniaxial", "biaxial", "shear"])
def test_stress_of_a_homogeneous_deformation_is_that_of_theory_everywhere(cell_type, F):
    points, cells = box(cell_type, distortion=0.2)
    skin = skin_state(FullModel(block_anatomy(points, cells, TISSUE)), displaced(points, F))
    expected = theory(TISSUE, F)
    np.testing.assert_allclose(skin.stress, np.broadcast_to(expected, skin.stress.shape), rtol=1e-9, atol=1e-6)
    principal = np.sort(np.linalg.eigvals(expected).real)[::-1]
    np.testing.assert_allclose(skin.principal_stresses[0], principal, rtol=1e-9, atol=1e-6)
    a, b, c = principal
    equivalent = np.sqrt(0.5 * ((a - b) ** 2 + (b - c) ** 2 + (c - a) ** 2))
    np.testing.assert_allclose(skin.von_mises, equivalent, rtol=1e-9)


@pytest.mark.parametrize("cell_type", sorted(ELEMENTS))
def test_stretches_lie_in_the_plane_of_the_skin(cell_type):
    """diag(1.2, 1.1, 0.8): the top sees 1.2 along x and 1.1 along y, never the 0.8 through it."""
    points, cells = box(cell_type)
    skin = skin_state(FullModel(block_anatomy(points, cells, TISSUE)), displaced(points, BIAXIAL))
    top = top_of(skin, points)
    assert len(top)
    np.testing.assert_allclose(skin.stretches[top], np.tile([1.2, 1.1], (len(top), 1)), rtol=1e-12)
    np.testing.assert_allclose(skin.strains[top], np.tile([0.22, 0.105], (len(top), 1)), rtol=1e-12)
    np.testing.assert_allclose(skin.area_ratios[top], 1.32, rtol=1e-12)
    np.testing.assert_allclose(np.abs(skin.directions[top]), np.tile([np.eye(3)[:2]], (len(top), 1, 1)), atol=1e-9)
    assert skin.areas[top].sum() == pytest.approx(0.02**2, rel=1e-12)


def test_simple_shear_stretches_along_the_rotated_diagonals():
    """Stretches sqrt(1 + g^2/4) +- g/2; the direction of the larger has tan(2 angle) = -2/g at rest (Ogden 1984)."""
    points, cells = box("hexahedron")
    skin = skin_state(FullModel(block_anatomy(points, cells, TISSUE)), displaced(points, SHEAR))
    top, g = top_of(skin, points), SHEAR[0, 1]
    expected = np.sqrt(1.0 + 0.25 * g * g) + np.array([0.5 * g, -0.5 * g])
    np.testing.assert_allclose(skin.stretches[top], np.tile(expected, (len(top), 1)), rtol=1e-12)
    x, y, _ = skin.directions[top, 0].T
    np.testing.assert_allclose(np.tan(2.0 * np.arctan2(y, x)), -2.0 / g, rtol=1e-9)


def test_rotation_turns_the_stress_and_leaves_principal_values():
    points, cells = box("tetra10", distortion=0.2)
    model = FullModel(block_anatomy(points, cells, TISSUE))
    u = 5e-4 * np.random.default_rng(0).normal(size=points.shape)
    turned = np.ascontiguousarray((points + u) @ TURN.T - points)
    before, after = skin_state(model, u), skin_state(model, turned)
    np.testing.assert_allclose(after.stretches, before.stretches, rtol=1e-9)
    np.testing.assert_allclose(after.stress, TURN @ before.stress @ TURN.T, rtol=1e-7, atol=1e-6)
    np.testing.assert_allclose(after.principal_stresses, before.principal_stresses, rtol=1e-7, atol=1e-6)


def test_pressure_is_that_of_the_mean_volume_change_of_the_cell():
    """With and without mean dilatation the stress differs by lam (ln Jbar / Jbar - ln J / J)."""
    points, cells = box("hexahedron", cells=(1, 1, 1))
    anatomy = block_anatomy(points, cells, TISSUE)
    u = np.zeros_like(points)
    u[-1] = [0.002, 0.001, 0.004]
    mean, local = (skin_state(FullModel(anatomy, mean_dilatation=choice), u) for choice in (True, False))
    model = FullModel(anatomy)
    volumes = model.discretisation.volumes[0].weights[0]
    average = volumes @ model.point_jacobians(u) / volumes.sum()
    isotropic = (mean.stress - local.stress)[:, 0, 0]
    np.testing.assert_allclose(mean.stress - local.stress, isotropic[:, None, None] * np.eye(3), atol=1e-6)
    film = FullModel(replace(anatomy, epidermis=1e-4)).discretisation.films[0]
    at_skin = np.linalg.det(film.deformation_gradients(u)[:, 0])
    expected = TISSUE.lame * (np.log(average) / average - np.log(at_skin) / at_skin)
    assert np.abs(expected).max() > 100.0
    np.testing.assert_allclose(isotropic, expected, rtol=1e-9, atol=1e-6)


def test_stress_on_a_face_is_what_the_bone_beneath_it_holds():
    """Nodal forces of the kernels on the fixed face z = 0 sum to -A P e_z, P = J sigma F^-T."""
    points, cells = box("wedge", distortion=0.2)
    model = FullModel(block_anatomy(points, cells, TISSUE))
    F = UNIAXIAL @ SHEAR
    u = displaced(points, F)
    stress = np.linalg.det(F) * skin_state(model, u).stress[0] @ np.linalg.inv(F).T
    reactions = bone_reactions(model, Equilibrium(np.zeros(0), u))
    np.testing.assert_allclose(reactions.skull, -(0.02**2) * stress[:, 2], rtol=1e-9, atol=1e-12)


def half_and_half():
    """A block of hexahedra of one tissue for x < 10 mm and of wedges of a stiffer one beyond."""
    points, hexahedra = box_hexahedra((2, 2, 2), (0.02, 0.02, 0.02))
    left = points[hexahedra].mean(axis=1)[:, 0] < 0.01
    cut = wedges(hexahedra[~left])
    soft = CellBlock("hexahedron", hexahedra[left], np.zeros(left.sum(), dtype=np.int64))
    stiff = CellBlock("wedge", cut, np.ones(len(cut), dtype=np.int64))
    skin = as_triangles(boundary_faces([soft, stiff]), points)
    anatomy = block_anatomy(points, soft, TISSUE)
    return replace(anatomy, cells=(soft, stiff), materials=(TISSUE, STIFF), skin=skin)


def test_each_triangle_has_the_tissue_of_the_cell_behind_it():
    anatomy = half_and_half()
    skin = skin_state(FullModel(anatomy), displaced(anatomy.points, UNIAXIAL))
    beyond = anatomy.points[skin.triangles].mean(axis=1)[:, 0] > 0.01
    expected = np.where(beyond[:, None, None], theory(STIFF, UNIAXIAL), theory(TISSUE, UNIAXIAL))
    np.testing.assert_allclose(skin.stress, expected, rtol=1e-9, atol=1e-6)


def test_vertex_values_are_means_weighted_by_area():
    skin = SkinState(
        triangles=np.array([[7, 2, 4], [2, 9, 4]]),
        areas=np.array([1.0, 2.0]),
        stretches=np.ones((2, 2)),
        directions=np.zeros((2, 2, 3)),
        stress=np.zeros((2, 3, 3)),
    )
    assert skin.vertices.tolist() == [2, 4, 7, 9]
    np.testing.assert_allclose(skin.at_vertices(np.array([1.0, 4.0])), [3.0, 3.0, 1.0, 4.0])
    np.testing.assert_allclose(skin.at_vertices(np.array([[1.0, 0.0], [4.0, 3.0]]))[0], [3.0, 2.0])


def test_folded_skin_is_an_error_that_names_the_triangle():
    points, cells = box("hexahedron", cells=(1, 1, 1))
    corner = np.zeros_like(points)
    corner[-1, 2] = -0.031
    with pytest.raises(SolverError, match=r"skin triangle\(s\) are folded, first triangle \d+ with J = -.*epidermis"):
        skin_state(FullModel(block_anatomy(points, cells, TISSUE)), corner)


LENGTH, SECTION, PULL = 0.06, 0.01 * 0.02, 50e3


def bar(cell_type, load):
    """A bar along x that is all muscle, held by the skull at x = 0 and the jaw at its other end."""
    points, cells = box(cell_type, cells=(4, 2, 2), size=(LENGTH, 0.01, 0.02))
    line = np.array([[0.0, 0.005, 0.01], [0.5 * LENGTH, 0.005, 0.01], [LENGTH, 0.005, 0.01]])
    return block_anatomy(
        points,
        cells,
        TISSUE,
        fixed=np.isclose(points[:, 0], 0.0),
        dragged=np.isclose(points[:, 0], LENGTH),
        muscles=(Muscle("pull", PolylineFibres((line,), radius=1.0), load),),
    )


@pytest.mark.parametrize("cell_type", sorted(ELEMENTS))
def test_a_bar_held_at_both_ends_pulls_its_bones_with_stress_times_section(cell_type):
    """Active stress along the axis leaves the sides free of traction: the bar stays as it is and pulls with a T A."""
    model = FullModel(bar(cell_type, ActiveStress(PULL)))
    found = EquilibriumSolver(model, tolerance=1e-10).solve(np.array([0.8, 0.0, 0.0, 0.0]))
    muscles, reactions = muscle_state(model, found), bone_reactions(model, found)
    pull = 0.8 * PULL * SECTION
    assert muscles.forces[0] == pytest.approx(pull, rel=1e-9)
    assert muscles.works[0] == pytest.approx(0.0, abs=1e-12 * pull)
    np.testing.assert_allclose(reactions.skull, [-pull, 0.0, 0.0], atol=1e-9 * pull)
    np.testing.assert_allclose(reactions.jaw, [pull, 0.0, 0.0], atol=1e-9 * pull)


def test_force_and_work_of_a_shortened_bar():
    """Stretch 0.7: force a T A 0.7 and work a T A L (1 - 0.7^2) / 2, from the energy T/2 |F a0|^2."""
    anatomy = bar("hexahedron", ActiveStress(PULL))
    shortened = displaced(anatomy.points, TURN @ np.diag([0.7, 1.2, 1.15]))
    state = muscle_state(FullModel(anatomy), Equilibrium(np.array([0.5, 0.0, 0.0, 0.0]), shortened))
    assert state.stretches[0] == pytest.approx(0.7, rel=1e-12)
    assert state.forces[0] == pytest.approx(0.5 * PULL * SECTION * 0.7, rel=1e-9)
    assert state.works[0] == pytest.approx(0.5 * PULL * SECTION * LENGTH * 0.5 * (1.0 - 0.49), rel=1e-9)


def test_force_density_is_held_by_the_origin_and_works_along_its_path():
    """A bar whose end moves by d, the rest in proportion: force a lambda V, work a lambda V d / 2."""
    density, volume = 1e6, LENGTH * SECTION
    model = FullModel(bar("hexahedron", ForceDensity(density)))
    moved = Equilibrium(np.array([0.5, 0.0, 0.0, 0.0]), displaced(model.anatomy.points, np.diag([0.9, 1.0, 1.0])))
    state = muscle_state(model, moved)
    assert state.stretches[0] == pytest.approx(0.9, rel=1e-12)
    assert state.forces[0] == pytest.approx(0.5 * density * volume, rel=1e-9)
    assert state.works[0] == pytest.approx(0.5 * density * volume * 0.5 * 0.1 * LENGTH, rel=1e-9)


@pytest.mark.parametrize("cell_type", sorted(ELEMENTS))
def test_work_is_what_the_active_energy_loses(cell_type):
    model = FullModel(muscle_block(cell_type, TISSUE))
    found = EquilibriumSolver(model).solve(np.array([0.9]))

    def active_energy(u):
        energies = []
        for parameters in (found.parameters, np.zeros(1)):
            model.set_parameters(parameters)
            energies.append(model.energy(u))
        return energies[0] - energies[1]

    work = muscle_state(model, found).works[0]
    assert work > 0.0
    assert work == pytest.approx(active_energy(np.zeros_like(found.u)) - active_energy(found.u), rel=1e-9)


def test_bones_balance_the_loads():
    """Skull and jaw both hold; a muscle pulls, a load acts: the reactions sum to minus the load."""
    anatomy = bar("tetra10", ActiveStress(PULL))
    load = np.random.default_rng(0).normal(size=anatomy.points.shape) * 1e-4
    load[anatomy.skull | anatomy.jaw] = 0.0
    model = FullModel(anatomy, [DeadLoad(load)])
    found = EquilibriumSolver(model, tolerance=1e-10).solve(np.array([0.5, 0.0, 0.0, 0.5]))
    reactions = bone_reactions(model, found)
    scale = np.linalg.norm(reactions.jaw)
    assert scale > 1.0
    np.testing.assert_allclose(reactions.skull + reactions.jaw, -load.sum(axis=0), atol=1e-8 * scale)


@pytest.mark.parametrize("cell_type", sorted(ELEMENTS))
def test_vtk_sees_cells_of_positive_volume_at_rest_and_deformed(cell_type, tmp_path):
    pyvista = pytest.importorskip("pyvista", reason="the extra `view` is not installed")
    points, cells = box(cell_type)
    model = FullModel(block_anatomy(points, cells, TISSUE))
    write_tissue(tmp_path / "a.vtu", model, Equilibrium(np.zeros(0), displaced(points, UNIAXIAL)))
    grid = pyvista.read(tmp_path / "a.vtu")
    for shape, change in ((grid, 1.0), (grid.warp_by_vector("displacement_m"), np.linalg.det(UNIAXIAL))):
        volumes = shape.compute_cell_sizes(length=False, area=False)["Volume"]
        assert volumes.min() > 0.0
        assert volumes.sum() == pytest.approx(change * 0.02**3, rel=1e-9)


def test_tissue_file_holds_the_state_of_every_cell(tmp_path):
    anatomy = half_and_half()
    line = np.array([[0.0, 0.01, 0.01], [0.02, 0.01, 0.01]])
    fibres = PolylineFibres((line,), radius=1.0)
    pull = (Muscle("a", fibres, ActiveStress(20e3)), Muscle("b", fibres, ActiveStress(10e3)))
    model = FullModel(replace(anatomy, muscles=pull))
    u = displaced(anatomy.points, BIAXIAL)
    write_tissue(tmp_path / "a.vtu", model, Equilibrium(np.array([0.5, 0.2]), u))
    mesh = meshio.read(tmp_path / "a.vtu")
    assert [block.type for block in mesh.cells] == ["hexahedron", "wedge"]
    np.testing.assert_array_equal(mesh.points, anatomy.points)
    np.testing.assert_array_equal(mesh.point_data["displacement_m"], u)
    np.testing.assert_array_equal(mesh.point_data["fixed_to_skull"], anatomy.skull)
    for number in range(2):
        assert (mesh.cell_data["layer"][number] == number).all()
        for name in ("J_mean", "J_smallest"):
            np.testing.assert_allclose(mesh.cell_data[name][number], np.linalg.det(BIAXIAL), rtol=1e-12)
        np.testing.assert_allclose(mesh.cell_data["active_stress_Pa"][number], 12e3, rtol=1e-12)


def test_skin_file_holds_the_state_of_every_triangle(tmp_path):
    points, cells = box("tetra10", distortion=0.2)
    model = FullModel(block_anatomy(points, cells, TISSUE))
    u = 1e-3 * np.sin(200.0 * points[:, [1, 2, 0]])
    skin = skin_state(model, u)
    write_skin(tmp_path / "skin.vtu", model, u, skin)
    mesh = meshio.read(tmp_path / "skin.vtu")
    triangles = mesh.cells_dict["triangle"]
    np.testing.assert_array_equal(mesh.points[triangles], points[skin.triangles])
    np.testing.assert_array_equal(mesh.point_data["displacement_m"][triangles], u[skin.triangles])
    expected = {
        "strain_1": skin.strains[:, 0],
        "stretch_2": skin.stretches[:, 1],
        "direction_2": skin.directions[:, 1],
        "area_ratio": skin.area_ratios,
        "stress_3_Pa": skin.principal_stresses[:, 2],
        "von_mises_Pa": skin.von_mises,
    }
    for name, values in expected.items():
        np.testing.assert_array_equal(mesh.cell_data[name][0], values)
    np.testing.assert_array_equal(mesh.point_data["strain_1"], skin.at_vertices(skin.strains[:, 0]))
