"""Training on a made-up face whose answer is known: two overlapping muscles that interact, and a jaw."""

import time
from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

import risorius
from risorius import measuring
from risorius.accuracy import HeldOut
from risorius.bases import pod
from risorius.companion import Companion
from risorius.errors import InputError
from risorius.evaluators import Setting
from risorius.evaluators.polynomial import _ridge_solution
from risorius.jaw import JawMotion
from risorius.pipeline import Pipeline, pipelines
from risorius.poses import Poses
from risorius.snapshot_file import SnapshotSet
from risorius.surface import CarriedSurface
from risorius.training import reduce_snapshots

JAW = JawMotion((0.0, -0.02, -0.06), 0.45, 0.008, 0.005, 0.008)


def answer(parameters, fields):
    """Displacement (n, 3) of the made-up face: polynomial in the muscles, rigid in the jaw."""
    a, b, opening, _, _ = parameters
    modal = np.tensordot([a + 0.2 * a * a, b, 0.4 * a * b, 0.1 * opening * a], fields[4:], axes=1)
    return modal + np.tensordot(JAW.lift_coordinates(parameters[2:]), fields[:4], axes=1)


def slopes(parameters, fields):
    """Derivatives (5, n, 3) of the answer by the parameters."""
    a, b, opening, _, _ = parameters
    by = [[1.0 + 0.4 * a, 0.0, 0.4 * b, 0.1 * opening], [0.0, 1.0, 0.4 * a, 0.0], [0.0, 0.0, 0.0, 0.1 * a]]
    result = np.zeros((5, *fields.shape[1:]))
    result[:3] = np.tensordot(by, fields[4:], axes=1)
    result[2:] += np.tensordot(JAW.lift_slopes(parameters[2:]), fields[:4], axes=1)
    return result


def made_up_surface(rng):
    """Forty vertices, each carried by three of the sixty nodes."""
    rows, shares = np.repeat(np.arange(40), 3), rng.dirichlet(np.ones(3), 40)
    weights = sp.csr_matrix((shares.ravel(), (rows, rng.integers(0, 60, 120))), shape=(40, 60))
    colours = rng.integers(0, 256, (40, 3)).astype(np.uint8)
    return CarriedSurface(rng.uniform(-0.05, 0.05, (40, 3)), rng.integers(0, 40, (80, 3)), weights, colours)


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
        surface=made_up_surface(rng),
        companions={
            "teeth": Companion(points[:5], np.array([[0, 1, 2], [2, 3, 4]]), np.zeros((5, 3), np.uint8), "jaw")
        },
        nodal_volumes=rng.uniform(1e-7, 2e-7, 60),
        lift_fields=fields[:4],
        body=None,
        contact=None,
        parameters=parameters,
        kinds=("made up",) * len(parameters),
        displacements=np.stack([answer(p, fields) for p in parameters]).astype(np.float32),
        derivatives=np.stack([slopes(p, fields) for p in parameters]).astype(np.float32),
        held_out=np.arange(len(parameters)) >= len(parameters) - held_out,
        smallest_jacobians=np.ones(len(parameters)),
        failures=(),
        provenance={"source": "made up"},
    ), fields


@pytest.fixture(scope="module")
def trained():
    snapshots, fields = made_up_snapshots()
    return snapshots, fields, reduce_snapshots(snapshots, rank=10)


def overall(model, method):
    """Errors over all held-out snapshots at full rank."""
    return next(point for point in model.points if point.setting == Setting(method, model.rank - model.lifts)).overall


def test_learned_map_finds_a_polynomial_answer_where_superposition_cannot(trained):
    snapshots, fields, model = trained
    frame = risorius.Engine(model).evaluate(muscles={"zygomaticus_major_L": 0.7, "zygomaticus_major_R": 0.9})
    exact = snapshots.surface.weights @ answer(np.array([0.7, 0.9, 0.0, 0.0, 0.0]), fields)
    found = frame.vertices - model.rest_vertices
    assert np.abs(found - exact).max() < 1e-5
    assert overall(model, "polynomial").p95 < 0.02 * overall(model, "superposition").p95


def test_a_model_shows_the_carried_surface_with_its_colours_and_companions(trained):
    snapshots, fields, model = trained
    visible = snapshots.surface
    np.testing.assert_allclose(model.rest_vertices, visible.points, rtol=1e-6)
    half_steps = np.abs(fields[:4]).max(axis=(1, 2), keepdims=True) / np.iinfo(np.int16).max
    assert (np.abs(model.basis[:4] - visible.carry(fields[:4])) <= half_steps).all()
    np.testing.assert_array_equal(model.triangles, visible.triangles)
    np.testing.assert_array_equal(model.colours, visible.colours)
    assert model.companions == snapshots.companions


def test_rank_is_that_of_the_data_and_snapshots_are_reproduced(trained):
    snapshots, _, model = trained
    assert len(model.basis) == 4 + 4  # four lifts, four independent made-up fields
    assert overall(model, "polynomial").maximum < 1e-4
    assert len(snapshots.parameters) == 125


def test_error_bounds_cover_the_share_of_held_out_snapshots_they_claim(trained):
    snapshots, _, model = trained
    held = HeldOut.of(snapshots)
    for point, way in zip(model.points, pipelines(model, [point.setting for point in model.points]), strict=True):
        covered = 0
        for parameters, truth in zip(held.parameters, held.displacements, strict=True):
            bound = point.bound.value(way.solve(parameters))
            vertices = np.empty_like(model.rest_vertices)
            way.write(vertices)
            covered += np.linalg.norm(vertices - model.rest_vertices - truth, axis=1).max() <= bound
        assert covered >= 0.95 * len(held.parameters)


def test_times_of_operating_points_leave_out_what_else_the_machine_does(trained, monkeypatch):
    snapshots, _, model = trained

    def slept(way, vertices):
        time.sleep(2e-3)

    monkeypatch.setattr(Pipeline, "write", slept)
    monkeypatch.setattr(measuring, "FRAMES", 16)
    points = measuring.measured(model, HeldOut.of(snapshots), measuring.settings(model)[:1])
    assert 0.0 < points[0].seconds.median < 1e-3


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


def test_a_model_of_a_coarser_mesh_is_begun_from_and_named(trained):
    snapshots, _, coarse = trained
    model = reduce_snapshots(snapshots, rank=10, coarse=coarse)
    assert model.provenance["coarse"] == f"{coarse.name}, {coarse.provenance['snapshots']} snapshots"
    assert not np.array_equal(
        model.evaluators["network"].members[0].first.values, coarse.evaluators["network"].members[0].first.values
    )
    assert overall(model, "network").p95 < 0.1 * overall(model, "superposition").p95


def test_a_coarse_model_of_another_face_is_refused(trained):
    snapshots, _, coarse = trained
    other = replace(coarse, inputs=replace(coarse.inputs, muscles=("zygomaticus_major_L", "frontalis_L")))
    with pytest.raises(InputError, match=r"other muscles or poses.*\(frontalis_L, zygomaticus_major_R\)"):
        reduce_snapshots(snapshots, rank=10, coarse=other)
    without = {name: one for name, one in coarse.evaluators.items() if name != "network"}
    with pytest.raises(InputError, match="has no network; train it from snapshots with derivatives"):
        reduce_snapshots(snapshots, rank=10, coarse=replace(coarse, evaluators=without))


class Told:
    """Keeps what training tells."""

    def __init__(self):
        self.names, self.shares = [], {}

    def begin(self, name):
        self.names.append(name)

    def reached(self, share):
        self.shares.setdefault(self.names[-1], []).append(share)


def test_training_tells_what_it_is_at(trained):
    snapshots, _, model = trained
    told = Told()
    same = reduce_snapshots(snapshots, rank=10, stages=told)
    assert told.names[0] == "modes" and told.names[-1] == "errors and times"
    assert len(set(told.names)) == len(told.names)
    assert list(told.shares) == ["network"]
    shares = told.shares["network"]
    assert len(shares) > 10 and shares == sorted(shares) and shares[-1] == 1.0
    np.testing.assert_array_equal(
        same.evaluators["network"].members[0].first.values, model.evaluators["network"].members[0].first.values
    )


def in_blocks(data, size=7):
    return lambda: (data[start : start + size] for start in range(0, len(data), size))


def test_pod_is_orthonormal_in_its_weights_and_best_among_bases():
    rng = np.random.default_rng(2)
    data = np.tensordot(rng.normal(size=(30, 8)) * 0.5 ** np.arange(8), rng.normal(size=(8, 40, 3)), axes=1)
    weights = rng.uniform(1.0, 3.0, 40)
    modes, _ = pod(in_blocks(data), weights, 5)
    gram = np.einsum("rni,n,sni->rs", modes, weights, modes)
    np.testing.assert_allclose(gram, np.eye(5), atol=1e-12)
    coordinates = np.einsum("sni,n,rni->sr", data, weights, modes)
    rest = data - np.tensordot(coordinates, modes, axes=1)
    scaled = data.reshape(30, -1) * np.sqrt(np.repeat(weights, 3))
    left_out = np.linalg.svd(scaled, compute_uv=False)[5:]
    # Eckart-Young: the squared error is the sum of the squared singular values left out.
    assert np.einsum("sni,n,sni->", rest, weights, rest) == pytest.approx((left_out**2).sum(), rel=1e-6)


def test_pod_in_blocks_is_the_singular_value_decomposition():
    """400 snapshots with slowly falling singular values, against LAPACK on all of them at once."""
    rng = np.random.default_rng(3)
    left, right = (np.linalg.qr(rng.normal(size=(size, 300)))[0] for size in (400, 900))
    exact = 1.0 / (1.0 + np.arange(300)) ** 1.5
    weights = rng.uniform(1.0, 3.0, 300)
    data = ((left * exact) @ right.T / np.sqrt(np.repeat(weights, 3))).reshape(400, 300, 3)
    modes, singular = pod(in_blocks(data, 64), weights, 20)
    np.testing.assert_allclose(singular, exact[:20], rtol=1e-6)
    overlap = np.einsum("rni,n,nis->rs", modes, np.sqrt(weights), right[:, :20].reshape(300, 3, 20))
    np.testing.assert_allclose(np.abs(overlap), np.eye(20), atol=1e-3)


def test_pod_keeps_no_more_modes_than_the_snapshots_have():
    rng = np.random.default_rng(4)
    data = np.tensordot(rng.normal(size=(3, 2)), rng.normal(size=(2, 10, 3)), axes=1)
    assert len(pod(in_blocks(data), np.ones(10), 5)[0]) == 2


def test_ridge_solutions_are_the_same_from_either_matrix():
    """With a snapshot more than monomials the smaller matrix is the other one; the extra snapshot is all zeros."""
    rng = np.random.default_rng(5)
    features, targets = rng.normal(size=(6, 6)), rng.normal(size=(6, 2))
    (dual,) = _ridge_solution(features, targets, [1e-3])
    (primal,) = _ridge_solution(np.vstack([features, np.zeros(6)]), np.vstack([targets, np.zeros(2)]), [1e-3])
    np.testing.assert_allclose(primal, dual, rtol=1e-9)
