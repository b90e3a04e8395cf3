"""One-sided springs at rest against the contact of the full model that they stand for."""

from dataclasses import replace

import numpy as np
import pytest

from risorius_offline.effects.bone_contact import BoneContact
from risorius_offline.effects.lip_seam import LipSeam
from risorius_offline.full_model import FullModel
from risorius_offline.one_sided import springs_at_rest
from tests.offline.test_bone_contact import box_surface, tissue_block
from tests.offline.test_lip_seam import EDGE, blocks


def forces_of(springs, u):
    overlap = np.maximum(-springs.play - springs.rows @ u.ravel(), 0.0)
    return -(springs.rows.T @ (springs.strength * overlap**2)).reshape(-1, 3)


def over_bone():
    """Tissue above a flat bone, by less than contact begins at and, where it is tilted, by more."""
    block = tissue_block()
    floor = box_surface([-0.05, -0.05, -0.03], [0.05, 0.05, block.points[:, 2].min() - 4e-4])
    anatomy = replace(block, bones={"maxilla": floor})
    return anatomy, BoneContact(anatomy), -0.03 * np.abs(anatomy.points[:, [0]]) * [0.0, 0.0, 1.0] - [0.0, 0.0, 1e-4]


def at_seam():
    """Faces that close, and turn towards each other by so little that what springs leave out is of second order."""
    anatomy = blocks(1e-3)
    closing = np.where(anatomy.points[:, 1] > EDGE + 0.5e-3, -1e-3 - 5e-4 * anatomy.points[:, 0], 0.0)
    return anatomy, LipSeam(anatomy), closing[:, None] * [0.0, 1.0, 0.0]


@pytest.mark.parametrize("made", [over_bone, at_seam])
def test_they_push_as_contact_does(made):
    anatomy, contact, u = made()
    expected = np.zeros_like(u)
    contact.add_forces(u, expected)
    found = forces_of(springs_at_rest(FullModel(anatomy, [contact])), u)
    assert np.abs(expected).max() > 1e-4
    np.testing.assert_allclose(found, expected, atol=1e-3 * np.abs(expected).max())


@pytest.mark.parametrize("made", [over_bone, at_seam])
def test_rest_and_what_leaves_are_free_of_them(made):
    anatomy, contact, u = made()
    springs = springs_at_rest(FullModel(anatomy, [contact]))
    assert (springs.play >= 0.0).all()
    assert not forces_of(springs, -u).any()


def test_a_model_without_contact_has_none():
    assert springs_at_rest(FullModel(tissue_block())) is None
