import numpy as np
import pytest

from risorius.inputs import InputTable
from risorius.jaw import JawMotion
from risorius.lids import LidMotion
from risorius_offline.sampling import PATH_LENGTH, design
from risorius_offline.sampling.actions import OPPONENTS, Actions
from risorius_offline.sampling.combinations import KINDS, points

MUSCLES = tuple(
    f"{name}_{side}"
    for name in (
        "zygomaticus_major",
        "depressor_anguli_oris",
        "mentalis",
        "risorius",
        "buccinator",
        "frontalis_medialis",
    )
    for side in "LR"
)
TABLE = InputTable(MUSCLES, JawMotion.inputs + LidMotion.inputs)
MIDLINE = InputTable(("pull",))
POSES_ONLY = InputTable((), JawMotion.inputs)


def rows(samples, *, held_out):
    chosen = samples.held_out == held_out
    return samples.parameters[chosen], samples.paths[chosen]


@pytest.mark.parametrize("table", [TABLE, MIDLINE, POSES_ONLY])
@pytest.mark.parametrize("lengths", [(40, 80), (100, 700)])
def test_a_longer_design_contains_a_shorter_one(table, lengths):
    short, long = (design(table, count, 5, seed=3) for count in lengths)
    for wanted, given in zip(rows(short, held_out=False), rows(long, held_out=False), strict=True):
        np.testing.assert_array_equal(wanted, given[: len(wanted)])
    for wanted, given in zip(rows(short, held_out=True), rows(long, held_out=True), strict=True):
        np.testing.assert_array_equal(wanted, given)
    assert len(long.parameters) == lengths[1] + 5
    assert short.held_out.sum() == 5


@pytest.mark.parametrize("table", [TABLE, MIDLINE, POSES_ONLY])
def test_no_sample_is_solved_twice_or_at_rest(table):
    parameters = design(table, 400, 50, seed=1).parameters
    assert len(np.unique(parameters, axis=0)) == 450
    assert (parameters != 0.0).any(axis=1).all()


def test_every_parameter_alone_is_there_however_few_are_asked_for():
    parameters, _ = rows(design(TABLE, 3, 2, seed=0), held_out=False)
    np.testing.assert_array_equal(parameters, np.eye(len(TABLE.parameters)))


def test_another_seed_is_another_design():
    assert not np.isin(design(TABLE, 200, 0, seed=4).parameters[100:], design(TABLE, 200, 0, seed=5).parameters).all()


def test_samples_stay_in_the_admissible_range_and_use_all_of_it():
    parameters = design(TABLE, 1000, 200, seed=0).parameters
    assert (parameters >= TABLE.parameter_lower).all()
    assert (parameters <= 1.0).all()
    np.testing.assert_allclose(parameters.min(axis=0), TABLE.parameter_lower, atol=0.05)
    np.testing.assert_allclose(parameters.max(axis=0), 1.0, atol=0.05)


def test_all_parts_of_the_design_are_there():
    kinds = set(design(TABLE, 200, 8, seed=0).kinds)
    assert kinds == {"single", "expression", "ramp", *KINDS}


def test_held_out_samples_are_ordinary_and_strong():
    samples = design(TABLE, 60, 40, seed=0)
    kinds = [kind for kind, held_out in zip(samples.kinds, samples.held_out, strict=True) if held_out]
    assert kinds.count("ordinary") == 30
    assert kinds.count("strong") == 10


def made(kind, count=256):
    actions = Actions.of(TABLE)
    return np.array([KINDS[kind](actions, point) for point in points(actions, count, (0,))])[:, : len(MUSCLES)]


def test_strong_combinations_have_five_to_all_actions_at_weights_from_0_6():
    left, right = made("strong")[:, 0::2], made("strong")[:, 1::2]
    taken = np.maximum(left, right)
    assert set((taken > 0.0).sum(axis=1)) == {5, 6}
    assert taken[taken > 0.0].min() >= 0.6


def test_ordinary_combinations_are_sparse_and_mostly_symmetric():
    left, right = made("ordinary")[:, 0::2], made("ordinary")[:, 1::2]
    sizes = (np.maximum(left, right) > 0.0).sum(axis=1)
    assert [np.sum(sizes == size) for size in (1, 2, 3, 4)] == [64, 64, 64, 64]
    symmetric = (left == right).all(axis=1)
    assert 0.6**2.5 * 0.5 < symmetric.mean() < 0.6  # from one to four actions, each symmetric six times in ten


def test_asymmetric_combinations_differ_between_left_and_right():
    left, right = made("asymmetric")[:, 0::2], made("asymmetric")[:, 1::2]
    assert (left != right).any(axis=1).all()


def test_opponents_pull_together():
    names = {frozenset(pair) for pair in OPPONENTS}
    for row in made("opposing", 32):
        active = {MUSCLES[k][:-2] for k in np.flatnonzero(row)}
        assert frozenset(active) in names


def test_weights_fill_their_range_more_evenly_than_random_ones():
    """Of 256 points of a Sobol sequence each of 256 equal intervals holds one, in every coordinate (Owen 1998)."""
    actions = Actions.of(TABLE)
    weights = np.array([point.muscles[1] for point in points(actions, 256, (7,))])
    np.testing.assert_array_equal(
        np.sort((256 * weights).astype(int), axis=0), np.arange(256)[:, None] + 0 * weights.astype(int)[:1]
    )


def test_samples_of_a_path_follow_one_another():
    _, paths = rows(design(TABLE, 21, 6, seed=0), held_out=False)
    assert np.bincount(paths)[::2].tolist() == [PATH_LENGTH] * 5 + [1]
