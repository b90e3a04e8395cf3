"""Training on a made-up face whose answer is known: two overlapping muscles that interact, and a jaw."""

import numpy as np
import pytest

import risorius
from risorius.bases import pod
from risorius.errors import InputError
from risorius.jaw import JawMotion
from risorius.poses import Poses
from risorius.snapshot_file import SnapshotSet
from risorius.training import reduce_snapshots

JAW = JawMotion((0.0, -0.02, -0.06), 0.45, 0.008, 0.005, 0.008)


def answer(parameters, fields):
    """Displacement (n, 3) of the made-up face: polynomial in the muscles, rigid in the jaw."""
    a, b, opening, _, _ = parameters
    modal = np.tensordot([a + 0.2 * a * a, b, 0.4 * a * b, 0.1 * opening * a], fields[4:], axes=1)
    return modal + np.tensordot(JAW.lift_coordinates(parameters[2:]), fields[:4], axes=1)


def made_up_snapshots(count=120, held_out=30):
    rng = np.random.default_rng(0)
    points = rng.uniform(-0.05, 0.05, (60, 3))
    fields = np.concatenate([JAW.unit_motions(points), rng.normal(size=(4, 60, 3)) * 2e-3])
    random = np.column_stack([rng.uniform(0, 1, (count, 3)), rng.uniform(-1, 1, (count, 2))])
    parameters = np.vstack([np.eye(5), random])
    return SnapshotSet(
        name="made up",
        muscles=("zygomaticus_major_L", "zygomaticus_major_R"),
        poses=Poses(JAW),
        points=points,
        skin=rng.integers(0, 60, (80, 3)),
        nodal_volumes=rng.uniform(1e-7, 2e-7, 60),
        lift_fields=fields[:4],
        parameters=parameters,
        displacements=np.stack([answer(p, fields) for p in parameters]).astype(np.float32),
        derivatives=np.zeros((len(parameters), 5, 60, 3), np.float32),
        held_out=np.arange(len(parameters)) >= len(parameters) - held_out,
        smallest_jacobians=np.ones(len(parameters)),
        failures=(),
        provenance={"source": "made up"},
    ), fields


@pytest.fixture(scope="module")
def trained():
    snapshots, fields = made_up_snapshots()
    return snapshots, fields, reduce_snapshots(snapshots, rank=10)


def test_learned_map_finds_a_polynomial_answer_where_superposition_cannot(trained):
    _, fields, model = trained
    skin = np.unique(trained[0].skin)
    frame = risorius.Engine(model).evaluate(muscles={"zygomaticus_major_L": 0.7, "zygomaticus_major_R": 0.9})
    exact = answer(np.array([0.7, 0.9, 0.0, 0.0, 0.0]), fields)[skin]
    found = frame.vertices - model.rest_vertices
    assert np.abs(found - exact).max() < 1e-5
    assert model.accuracy["polynomial"].p95 < 0.02 * model.accuracy["superposition"].p95


def test_rank_is_that_of_the_data_and_snapshots_are_reproduced(trained):
    snapshots, _, model = trained
    assert len(model.basis) == 4 + 4  # four lifts, four independent made-up fields
    assert model.accuracy["polynomial"].maximum < 1e-4
    assert len(snapshots.parameters) == 125


def test_error_bound_covers_the_share_of_held_out_snapshots_it_claims(trained):
    for accuracy in trained[2].accuracy.values():
        assert accuracy.coverage >= 0.95


def test_held_out_snapshots_are_never_read_for_training(trained):
    snapshots, _, model = trained
    spoiled = snapshots.displacements.copy()
    spoiled[snapshots.held_out] += 1e-2
    other = reduce_snapshots(SnapshotSet(**{**vars(snapshots), "displacements": spoiled}), rank=10)
    np.testing.assert_array_equal(other.basis, model.basis)
    np.testing.assert_array_equal(
        other.evaluators["polynomial"].coefficients, model.evaluators["polynomial"].coefficients
    )


def test_missing_single_action_is_named():
    snapshots, _ = made_up_snapshots()
    keep = np.arange(len(snapshots.parameters)) != 1
    arrays = {name: getattr(snapshots, name)[keep] for name in
              ("parameters", "displacements", "held_out", "smallest_jacobians")}  # fmt: skip
    with pytest.raises(InputError, match="zygomaticus_major_R alone at weight 1 is missing"):
        reduce_snapshots(SnapshotSet(**{**vars(snapshots), **arrays}), rank=5)


def test_snapshot_file_comes_back_as_it_was(tmp_path):
    snapshots, _ = made_up_snapshots(10, 2)
    snapshots.save(tmp_path / "s.h5")
    loaded = SnapshotSet.load(tmp_path / "s.h5")
    for name in SnapshotSet._ARRAYS:
        np.testing.assert_array_equal(getattr(loaded, name), getattr(snapshots, name))
    assert loaded.poses == snapshots.poses


def test_pod_is_orthonormal_in_its_weights_and_best_among_bases():
    rng = np.random.default_rng(2)
    data = np.tensordot(rng.normal(size=(30, 8)) * 0.5 ** np.arange(8), rng.normal(size=(8, 40, 3)), axes=1)
    weights = rng.uniform(1.0, 3.0, 40)
    modes, singular = pod(data, weights, 5)
    gram = np.einsum("rni,n,sni->rs", modes, weights, modes)
    np.testing.assert_allclose(gram, np.eye(5), atol=1e-12)
    coordinates = np.einsum("sni,n,rni->sr", data, weights, modes)
    rest = data - np.tensordot(coordinates, modes, axes=1)
    # Eckart-Young: the squared error is the sum of the squared singular values left out.
    assert np.einsum("sni,n,sni->", rest, weights, rest) == pytest.approx((singular[5:] ** 2).sum(), rel=1e-6)
