"""Other proportions of the built-in head: what they ask for, whatever they are, on a sound mesh that solves."""

from dataclasses import replace

import numpy as np
import pytest

from risorius.errors import InputError
from risorius_offline.contact_choice import ContactChoice
from risorius_offline.effect_choice import EffectChoice
from risorius_offline.equilibrium import EquilibriumSolver
from risorius_offline.head.proportions import ADULT, NORMS
from risorius_offline.head.quality import scaled_jacobians
from risorius_offline.head.reshape import reshaped
from tests.offline.head_measures import LEVELS, distances, level, openings

NUMBERS = range(30)
SOLVED = (0, 7, 19)


@pytest.mark.parametrize("number", NUMBERS)
def test_all_distances_come_out_and_no_cell_gets_bad(sculpted_head, thirty_proportions, number):
    wanted = thirty_proportions[number]
    head = reshaped(sculpted_head, wanted)
    for name, value in distances(sculpted_head, head).items():
        assert value == pytest.approx(getattr(wanted, name), rel=0.08), name
    worst = scaled_jacobians(head.points, head.cells[0].connectivity).min(axis=1)
    assert worst.min() >= 0.05
    assert np.percentile(worst, 1.0) >= 0.15


@pytest.mark.parametrize("number", SOLVED)
def test_face_smiles_and_opens_its_mouth_on_its_teeth(sculpted_head, thirty_proportions, number):
    smile_and_open(reshaped(sculpted_head, thirty_proportions[number]))


@pytest.mark.slow
@pytest.mark.parametrize("number", sorted(set(NUMBERS) - set(SOLVED)))
def test_any_face_smiles_and_opens_its_mouth_on_its_teeth(sculpted_head, thirty_proportions, number):
    smile_and_open(reshaped(sculpted_head, thirty_proportions[number]))


def test_closed_lids_leave_no_gap(adult_head):
    solver = EquilibriumSolver(EffectChoice(contact=ContactChoice.BONES).model(adult_head))
    closed = solver.solve(parameters(adult_head, AU43=1.0))
    moved = replace(adult_head, points=adult_head.points + closed.u)
    for eye in openings(adult_head)[1:]:
        for number in range(LEVELS):
            margin = level(moved, number)[eye]
            upper = adult_head.lids.reshape(LEVELS, -1)[0][eye] != 0
            lower = margin[~upper][margin[~upper][:, 0].argsort()]
            gap = margin[upper][:, 1] - np.interp(margin[upper][:, 0], lower[:, 0], lower[:, 1])
            assert gap.max() < 1e-3


def test_distance_far_from_its_norm_is_named_with_its_range():
    with pytest.raises(InputError, match=r"n_gn = 0.16 m; give a distance from 0.095 to 0.143 m"):
        replace(ADULT, n_gn=0.160)
    with pytest.raises(InputError, match="ch_ch = nan"):
        replace(ADULT, ch_ch=float("nan"))


def test_proportions_that_leave_no_room_for_a_nose_are_refused(sculpted_head):
    impossible = {"n_gn": -3.5, "sn_gn": 3.5, "ex_ex": 3.5, "en_en": -3.5}
    fields = {name: NORMS[name].mean + off * NORMS[name].deviation for name, off in impossible.items()}
    with pytest.raises(InputError, match=r"inside out.*3\.5 standard deviations"):
        reshaped(sculpted_head, replace(ADULT, **fields))


def parameters(head, **values):
    return head.inputs.to_parameters(head.inputs.weights(values))


def smile_and_open(head):
    solver = EquilibriumSolver(EffectChoice(contact=ContactChoice.BONES).model(head))
    smile = solver.solve(parameters(head, AU12=1.0))
    opened = solver.solve(parameters(head, AU26=1.0))
    assert smile.report.stable
    assert opened.report.stable
    mouth = openings(head)[0]
    corner = mouth[level(head, LEVELS - 1)[mouth, 0].argmax()]
    assert level_of(smile.u, LEVELS - 1)[corner, 1] > 2e-3
    assert opened.u[:, 1].min() < -0.015


def level_of(field, number):
    return field.reshape(LEVELS, -1, 3)[number]
