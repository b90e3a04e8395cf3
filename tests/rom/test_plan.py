"""A scene's smaller model against the whole one."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from tests.conftest import synthetic_point

from risorius import Engine, InputError, Scene
from risorius.carried_basis import CarriedBasis
from risorius.coarsening import coarse_surface
from risorius.effects.inertia import Inertia
from risorius.effects.strain_lag import StrainLag
from risorius.effects.vibrations import Vibrations
from risorius.evaluators import PolynomialMap, RationalMap, Setting, Superposition
from risorius.evaluators.products import as_products
from risorius.evaluators.rational import Block
from risorius.inputs import InputTable
from risorius.lids import LidMotion
from risorius.plan import planned
from risorius.poses import Poses

MUSCLES = ("zygomaticus_major_L", "zygomaticus_major_R", "frontalis_medialis_L", "frontalis_medialis_R")
LIDS = LidMotion(((0.03, 0.0, 0.02), (-0.03, 0.0, 0.02)), 0.5)
TERMS = [(0,), (1,), (2,), (3,), (4,), (5,), (7,), (0, 0), (0, 1), (2, 3), (0, 4), (0, 0, 4), (1, 4), (4, 5), (2, 7)]
LOWER, UPPER = slice(0, 4), slice(4, 8)  # modes of the skin of either half
METHODS = ("superposition", "polynomial", "rational")
EXACT = 1e-5  # metres: what a plan promises


@pytest.fixture(scope="module")
def model(synthetic_model):
    """A face whose brows and mouth have modes of their own, and whose parameters compete and interact at random."""
    rng, poses = np.random.default_rng(3), Poses(synthetic_model.poses.jaw, LIDS)
    rest = synthetic_model.rest_vertices.astype(float)
    upper = rest[:, 1] > -0.04
    modes = rng.normal(size=(8, len(rest), 3)) * 1e-3
    modes[LOWER, upper] = modes[UPPER, ~upper] = 0.0
    lids = LIDS.unit_motions(rest) * upper[:, None]
    jaw = poses.jaw.unit_motions(rest) * ~upper[:, None]
    brows = np.array([min(term) in (2, 3, 7) for term in TERMS])
    acts = brows[:, None] == (np.arange(8) >= 4)
    actions = np.zeros((9, 8))
    actions[:2, LOWER], actions[2:4, UPPER] = rng.normal(size=(2, 2, 4))
    exponents = np.array([term + (-1,) * (3 - len(term)) for term in TERMS], np.int32)
    return replace(
        synthetic_model,
        inputs=InputTable(MUSCLES, poses.inputs),
        poses=poses,
        carried_basis=CarriedBasis.of_vertices(np.concatenate([jaw, lids, modes]).astype(np.float32)),
        evaluators={
            "superposition": Superposition(actions),
            "polynomial": PolynomialMap(exponents, rng.normal(size=acts.shape) * acts),
            "rational": rational_map(rng, acts),
        },
        points=tuple(synthetic_point(Setting(method, 8), 1e-3, 1e-5) for method in METHODS),
    )


def rational_map(rng, acts):
    """Two blocks of modes, with features of one term and of two, and of two kinks of the mouth."""
    images = np.array([TERMS.index(tuple(sorted({0: 1, 1: 0}.get(i, i) for i in t))) if t in ((0,), (1,)) else n
                       for n, t in enumerate(TERMS)], np.int32)  # fmt: skip
    pairs = np.column_stack([np.arange(len(TERMS), dtype=np.int32), images])
    signs = np.where(pairs[:, 0] == images, 0.0, rng.choice([-1.0, 1.0], len(TERMS)))
    pairs, signs = np.vstack([pairs, np.int32([[len(TERMS), len(TERMS) + 1]])]), np.append(signs, -1.0)
    acts = np.vstack([acts, np.arange(8) < 4])
    kinks = np.zeros((9, 2))
    kinks[[0, 4], 0] = kinks[[1, 4], 1] = 1.0, -0.5
    blocks = tuple(
        Block(pairs, signs, modes, (rng.normal(size=acts.shape) * acts)[:, modes].astype(np.float32))
        for modes in (np.arange(0, 8, 2), np.arange(1, 8, 2))
    )
    return RationalMap(rng.uniform(0, 1, (9, 9)), as_products(TERMS), kinks, blocks)


def with_method(model, method):
    return replace(model, points=tuple(point for point in model.points if point.setting.method == method))


def largest_difference(model, scene, seed=0):
    """Of the vertices that the scene keeps, over random weights of its inputs."""
    whole, engine = Engine(model, Scene(nonlinear=scene.nonlinear)), Engine(model, scene)
    rng, found = np.random.default_rng(seed), []
    for _ in range(20):
        weights = dict(zip(engine.inputs, rng.uniform(engine.model.inputs.lower, 1.0), strict=True))
        muscles = {name: weights.pop(name) for name in set(weights) & set(MUSCLES)}
        expected = whole.evaluate(weights, muscles=muscles).vertices[engine.vertex_numbers]
        frame = engine.evaluate(weights, muscles=muscles)
        assert np.ptp(frame.coordinates) > 0.0
        found.append(np.linalg.norm(frame.vertices - expected, axis=1).max())
    return max(found)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("inputs", [("AU12",), ("AU12_L", "jaw_open"), ("AU1", "AU43_L"), ("frontalis_medialis_R",)])
def test_few_inputs_move_the_face_as_the_whole_model_does(model, method, inputs):
    scene = Scene(nonlinear=method != "superposition", inputs=inputs)
    assert largest_difference(with_method(model, method), scene) < EXACT


@pytest.mark.parametrize("region", ["mouth", "brows", tuple(range(0, 320, 7))])
def test_a_region_moves_as_it_does_in_the_whole_model(model, region):
    assert largest_difference(with_method(model, "rational"), Scene(region=region)) < EXACT


def test_what_no_input_can_drive_is_not_there(model):
    left = planned(model, Scene(inputs=("AU12_L",))).model
    assert left.inputs.parameters == ("zygomaticus_major_L",)
    assert left.inputs.names == ("AU12_L",)
    assert left.lifts == 0
    assert left.rank == 4
    assert len(left.evaluators["rational"].products.parents) == 2
    assert left.evaluators["polynomial"].exponents.tolist() == [[0, -1, -1], [0, 0, -1]]


def test_a_muscle_that_is_asked_for_by_name_is_an_input(model):
    engine = Engine(model, Scene(inputs=("frontalis_medialis_R", "AU12")))
    assert engine.inputs == ("AU12_L", "AU12_R", "frontalis_medialis_R")
    by_input = engine.evaluate({"frontalis_medialis_R": 0.6}).vertices
    np.testing.assert_array_equal(by_input, engine.evaluate(muscles={"frontalis_medialis_R": 0.6}).vertices)


def test_a_motion_is_kept_whole_and_its_other_weights_stay_zero(model):
    left = planned(model, Scene(inputs=("AU26",))).model
    assert left.inputs.poses == ("jaw_open", "jaw_forward", "jaw_sideways")
    assert left.inputs.names == ("AU26",)
    assert left.lifts == 4
    assert len(left.evaluators["rational"].products.parents) == 1


def test_modes_that_a_region_does_not_see_are_not_there(model):
    assert planned(model, Scene(region="mouth")).model.rank - model.lifts == 4
    assert planned(model, Scene(region="brows")).model.rank - model.lifts == 5  # the first is always kept


def test_a_named_region_is_where_its_muscles_move_the_skin(model):
    fields = np.tensordot(model.evaluators["superposition"].actions[2:4], model.basis[8:], axes=1)
    moved = np.linalg.norm(fields, axis=2)
    inside = (moved >= 0.5 * moved.max(axis=1, keepdims=True)).any(axis=0)
    expected = np.unique(model.triangles[inside[model.triangles].all(axis=1)])
    np.testing.assert_array_equal(planned(model, Scene(region="brows")).vertex_numbers, expected)


def test_triangles_of_a_region_are_those_of_the_face(model):
    engine = Engine(model, Scene(region="mouth"))
    own = {tuple(triangle) for triangle in engine.vertex_numbers[engine.triangles].tolist()}
    inside = np.isin(model.triangles, engine.vertex_numbers).all(axis=1)
    assert own == {tuple(triangle) for triangle in model.triangles[inside].tolist()}


def test_everything_is_the_model_itself(model):
    left = planned(model, Scene()).model
    assert left.carried_basis is model.carried_basis
    assert left.evaluators == model.evaluators


def test_a_linear_scene_holds_no_other_map(model):
    assert set(planned(model, Scene(nonlinear=False)).model.evaluators) == {"superposition"}


def test_a_scene_without_a_jaw_has_none(model):
    engine = Engine(model, Scene(jaw=False))
    assert engine.model.poses.jaw is None
    assert not {"AU26", "AU27", "jaw_open"} & set(engine.inputs)
    assert largest_difference(model, Scene(jaw=False)) < EXACT


def test_the_bound_of_a_part_is_that_of_the_whole(model):
    """What it is made from is told by the modes that are kept."""
    weights = {"AU12_L": 0.7, "AU12_R": 0.2}
    few, whole = (Engine(model, scene).evaluate(weights) for scene in (Scene(inputs=("AU12",)), Scene()))
    assert few.error == pytest.approx(whole.error, rel=1e-3)


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        (Scene(inputs=("AU99",)), "scene: inputs: input 'AU99' is not known"),
        (Scene(inputs=()), "scene: inputs: none given"),
        (Scene(inputs=("AU26",), jaw=False), "scene: inputs: input 'AU26' needs jaw_open"),
        (Scene(region=(0, 320)), "scene: region: vertex 320 given; give numbers from 0 to 319"),
        (Scene(region=()), "scene: region: no vertex given"),
        (Scene(region=(3, 9), resolution="carriers"), "scene: resolution: carriers need a surface"),
    ],
)
def test_what_the_model_has_not_is_refused(model, scene, message):
    with pytest.raises(InputError, match=f"^{message}"):
        Engine(model, scene)


def test_a_jaw_or_a_region_that_the_model_lacks_is_refused(model):
    rigid = replace(model, poses=Poses(None, LIDS), inputs=InputTable(MUSCLES, LIDS.inputs))
    with pytest.raises(InputError, match="scene: jaw: model 'synthetic' has none"):
        planned(rigid, Scene(jaw=True))
    only_mouth = replace(model, inputs=InputTable(MUSCLES[:2], model.poses.inputs), poses=Poses(model.poses.jaw))
    with pytest.raises(InputError, match="scene: region: 'brows' is where frontalis"):
        planned(only_mouth, Scene(region="brows"))


def grid(side, spacing):
    x, y = np.meshgrid(np.arange(side) * spacing, np.arange(side) * spacing, indexing="ij")
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    first, second = [corner, corner + side, corner + side + 1], [corner, corner + side + 1, corner + 1]
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(side**2)]).astype(np.float32)
    return points, np.concatenate([np.column_stack(first), np.column_stack(second)]).astype(np.int32)


def test_a_refined_grid_becomes_its_coarse_one_again():
    """Every third point of the fine grid carries itself; the others follow bilinearly."""
    points, triangles = grid(13, 0.01)
    along = np.maximum(1.0 - np.abs(np.arange(13)[:, None] / 3.0 - np.arange(5)), 0.0)
    kept, coarse = coarse_surface(points, triangles, sp.csr_matrix(np.kron(along, along)))
    own = np.arange(0, 13, 3)
    np.testing.assert_array_equal(kept, (13 * own[:, None] + own).ravel())
    corners = points[kept][coarse]
    areas = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (areas[:, 2] > 0.0).all()
    assert areas[:, 2].sum() == pytest.approx(0.12**2, rel=1e-5)
    edges = {frozenset(triangle[[i, i - 1]].tolist()) for triangle in coarse for i in range(3)}
    assert len(kept) - len(edges) + len(coarse) == 1  # Euler characteristic of a disk


def test_coarse_vertices_are_vertices_of_the_face(model):
    weights = sp.csr_matrix(np.kron(np.eye(160), np.ones((2, 1))))
    fields = model.carried_basis.fields[:, ::2]
    carried = replace(model, carried_basis=CarriedBasis(np.ascontiguousarray(fields), weights))
    engine = Engine(carried, Scene(resolution="carriers"))
    assert len(engine.vertex_numbers) == 160
    assert largest_difference(carried, Scene(resolution="carriers")) < EXACT


def test_an_effect_that_is_off_is_not_there(model):
    """What runs is what would run had the model been trained without it: the same code on the same numbers."""
    count = len(model.rest_vertices)
    fields, vibrations = np.ones((1, count, 3), np.float32), Vibrations(np.array([4e4]), np.array([2e3]))
    strain_lag = StrainLag.none(4, model.rank - model.lifts)
    shaking = Inertia(fields, vibrations, np.ones((1, model.rank)), model.lifts, strain_lag)
    with_inertia = replace(model, effects={"inertia": shaking})
    off, bare = (Engine(*one) for one in ((with_inertia, Scene(inertia=False)), (model, Scene())))
    assert (off.effects, Engine(with_inertia).effects) == ((), ("inertia",))
    assert {name: value for name, value in vars(off.model).items() if name != "points"} == {
        name: value for name, value in vars(bare.model).items() if name != "points"
    }
    weights = {"AU12": 0.7, "jaw_open": 0.2}
    np.testing.assert_array_equal(off.evaluate(weights).vertices, bare.evaluate(weights).vertices)
    with pytest.raises(InputError, match="step: the scene of this engine is without inertia"):
        off.evaluate(weights, step=0.01)


def test_an_effect_acts_on_a_part_as_on_the_whole(model):
    count = len(model.rest_vertices)
    rng = np.random.default_rng(5)
    fields = rng.normal(size=(1, count, 3)).astype(np.float32)
    vibrations, static = Vibrations(np.array([4e4]), np.array([2e3])), rng.normal(size=(1, model.rank)) * 1e-3
    strain_lag = StrainLag(rng.normal(size=(4, model.rank - model.lifts)), np.full(4, 0.03))
    shaking = Inertia(fields, vibrations, static, model.lifts, strain_lag)
    with_inertia = replace(model, effects={"inertia": shaking})
    whole, part = Engine(with_inertia), Engine(with_inertia, Scene(inputs=("AU12", "AU26"), region="mouth"))
    for number in range(20):
        weights = {"AU12": 0.5 * (number > 2), "AU26": 0.8 * (number > 5)}
        first, second = (engine.evaluate(weights, step=0.005).vertices for engine in (whole, part))
        np.testing.assert_allclose(second, first[part.vertex_numbers], atol=EXACT)
