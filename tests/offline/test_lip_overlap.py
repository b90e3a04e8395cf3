"""Skin of two blocks that face each other: what is found to overlap, its energy, and how deep pressed blocks stay."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from risorius.surface import NO_COLOURS, CarriedSurface
from risorius_offline.effects.contact_surface import ContactSurface
from risorius_offline.effects.dead_load import DeadLoad
from risorius_offline.effects.lip_overlap import DEPTH, PRESSURE, LipOverlap, pressure, pressure_slope, work
from risorius_offline.equilibrium import TOLERATED, EquilibriumSolver
from risorius_offline.full_model import FullModel
from risorius_offline.sensitivities import gravity_sensitivities
from tests.offline.test_lip_seam import EDGE, blocks, check_derivatives, turn

GAP = 0.4e-3


def skinned(gap=GAP):
    """The two blocks of the seam's tests, with all of their boundary for visible skin."""
    anatomy = blocks(gap)
    boundary = ContactSurface.of(anatomy)
    weights = sp.csr_matrix(
        (np.ones(len(boundary.nodes)), (np.arange(len(boundary.nodes)), boundary.nodes)),
        shape=(len(boundary.nodes), len(anatomy.points)),
    )
    return replace(anatomy, surface=CarriedSurface(boundary.points, boundary.triangles, weights, NO_COLOURS))


def upper(anatomy):
    return anatomy.points[:, 1] > EDGE + 0.5 * GAP


def lowered(anatomy, depth):
    """The upper block down by its gap and so much more."""
    return np.where(upper(anatomy)[:, None], [0.0, -GAP - depth, 0.0], 0.0)


def paired(anatomy, u):
    overlap = LipOverlap(anatomy)
    overlap.hold_contacts(overlap.search_contacts(u))
    return overlap


def missed_depth(overlap, u):
    """Metres by which what overlaps at u is deeper than by the pairs that the effect holds."""
    return overlap.missed_depth(u, overlap.search_contacts(u))


def test_nothing_overlaps_at_rest_nor_on_an_anatomy_without_lips():
    anatomy = skinned()
    rest = np.zeros_like(anatomy.points)
    assert missed_depth(LipOverlap(anatomy), rest) == 0.0
    assert missed_depth(LipOverlap(skinned(5e-3)), rest) == 0.0


def test_what_overlaps_is_missed_by_its_depth_until_it_is_paired():
    anatomy = skinned()
    overlap, u = LipOverlap(anatomy), lowered(anatomy, 0.3e-3)
    assert overlap.energy(u) == 0.0
    assert missed_depth(overlap, u) == pytest.approx(0.3e-3, rel=1e-9)
    overlap.hold_contacts(overlap.search_contacts(u))
    assert missed_depth(overlap, u) == 0.0
    deeper = lowered(anatomy, 0.8e-3)
    assert missed_depth(overlap, deeper) == 0.0  # planes of pairs have no end


def test_blocks_side_by_side_do_not_overlap():
    """The upper one beside the other, 5 mm down: all of it is beyond the rim."""
    anatomy = skinned()
    u = np.where(upper(anatomy)[:, None], [EDGE + 1e-3, -5e-3, 0.0], 0.0)
    assert missed_depth(LipOverlap(anatomy), u) == 0.0


def test_block_that_has_slid_is_paired_with_what_it_lies_on_now():
    """Nothing of 6 mm is in reach of pairs of rest; where blocks overlap the depth is that of the upper one."""
    anatomy = skinned()
    u = lowered(anatomy, 0.3e-3) + np.where(upper(anatomy)[:, None], [6e-3, 0.0, 0.0], 0.0)
    assert missed_depth(LipOverlap(anatomy), u) == pytest.approx(0.3e-3, rel=1e-9)


def test_energy_is_the_work_of_the_pressure_on_the_area_that_overlaps():
    """The upper block is moved aside, too, so that no point lies over a rim of the other one."""
    anatomy, depth = skinned(), 0.3e-3
    u = lowered(anatomy, depth) + np.where(upper(anatomy)[:, None], [1e-3, 0.0, 1e-3], 0.0)
    surface, x = ContactSurface.of(anatomy), (anatomy.points + u)[:, [0, 2]]
    meets = ((x > 1e-3 - 1e-9) & (x < EDGE + 1e-9)).all(axis=1)
    meets &= np.isclose(anatomy.points[:, 1], EDGE) | np.isclose(anatomy.points[:, 1], EDGE + GAP)
    area = 0.5 * surface.areas[meets[surface.nodes]].sum()
    assert paired(anatomy, u).energy(u) == pytest.approx(area * work(np.array([depth]))[0], rel=1e-9)


def test_pressure_is_the_derivative_of_its_work_and_has_one_itself():
    depths, h = np.linspace(0.05, 8.0, 60) * DEPTH, 1e-6 * DEPTH
    np.testing.assert_allclose((work(depths + h) - work(depths - h)) / (2.0 * h), pressure(depths), rtol=1e-6)
    np.testing.assert_allclose(
        (pressure(depths + h) - pressure(depths - h)) / (2.0 * h), pressure_slope(depths), rtol=1e-5
    )
    assert pressure(np.array([DEPTH]))[0] == pytest.approx(PRESSURE)
    assert pressure(np.array([1.0]))[0] < 3.0 * PRESSURE


def test_forces_and_second_derivatives_are_those_of_the_energy():
    anatomy, rng = skinned(), np.random.default_rng(0)
    u = lowered(anatomy, 0.3e-3) + 1e-4 * rng.normal(size=anatomy.points.shape)
    overlap = paired(anatomy, u)
    check_derivatives(overlap, u, rng.normal(size=anatomy.points.shape))
    lowest = [np.linalg.eigvalsh(m)[0] for m in overlap.second_derivatives(u, project=True).matrices]
    assert min(lowest) > -1e-9


def test_contact_forces_are_in_balance():
    anatomy = skinned()
    u = (anatomy.points + lowered(anatomy, 0.3e-3)) @ turn(30.0).T - anatomy.points
    forces = np.zeros_like(u)
    paired(anatomy, u).add_forces(u, forces)
    size = np.abs(forces).sum()
    assert size > 0.0
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-12 * size)
    np.testing.assert_allclose(np.cross(anatomy.points + u, forces).sum(axis=0), 0.0, atol=1e-12 * EDGE * size)


def pressed(anatomy, *others):
    """Equilibrium of the blocks, the upper one pressed down by 1 kPa at the face that meets the other."""
    face = np.isclose(anatomy.points[:, 1], EDGE + GAP)
    surface = ContactSurface.of(anatomy)
    areas = np.zeros(len(anatomy.points))
    areas[surface.nodes] = surface.areas
    load = np.where(face[:, None], [0.0, -1e3, 0.0], 0.0) * areas[:, None]
    model = FullModel(anatomy, (DeadLoad(load), *others))
    return model, EquilibriumSolver(model).solve(np.zeros(0))


def test_pressed_blocks_are_kept_from_getting_into_each_other(monkeypatch):
    """And no state is searched twice on the way."""
    anatomy, searched = skinned(), []
    overlap = LipOverlap(anatomy)
    search = overlap.search_contacts
    monkeypatch.setattr(overlap, "search_contacts", lambda u: searched.append(u.tobytes()) or search(u))
    (_, without), (_, found) = pressed(anatomy), pressed(anatomy, overlap)
    assert len(set(searched)) == len(searched) > 2
    fresh = LipOverlap(anatomy)
    assert missed_depth(fresh, without.u) > 3.0 * DEPTH
    assert missed_depth(fresh, found.u) < DEPTH
    assert missed_depth(overlap, found.u) <= TOLERATED


def test_derivatives_of_an_equilibrium_are_the_same_after_the_model_was_elsewhere():
    anatomy = skinned()
    model, found = pressed(anatomy, LipOverlap(anatomy))
    first = gravity_sensitivities(model, found)
    EquilibriumSolver(model).solve(np.zeros(0))
    model.hold_contacts(())
    again = gravity_sensitivities(model, found)
    np.testing.assert_allclose(again, first, rtol=0.0, atol=1e-9 * np.abs(first).max())
