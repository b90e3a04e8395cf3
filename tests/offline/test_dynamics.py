"""Motion against the theory of vibrations, against statics, and without a gain of energy."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp

from risorius.errors import InputError
from risorius.mechanics.material import Yeoh
from risorius_offline.discretisation import Discretisation
from risorius_offline.dynamics import MotionSolver
from risorius_offline.effects import DeadLoad
from risorius_offline.equilibrium import EquilibriumSolver, NotConvergedError
from risorius_offline.full_model import FullModel
from risorius_offline.inertia import Inertia, Medium
from tests.offline.meshes import box
from tests.offline.models import block_anatomy, muscle_block

TISSUE = Yeoh(2500.0, 1175.0, 250e3)
UNDAMPED = Medium(mass_damping=0.0, stiffness_damping=0.0)
LENGTH = 0.04


class Bar:
    """A bar along z, held at z = 0 and by two planes of symmetry, with its axial mode by scipy's eigh."""

    def __init__(self):
        self.material = Yeoh.neo_hookean(15e3, 0.3)
        points, cells = box("hexahedron", cells=(1, 1, 8), size=(0.005, 0.005, LENGTH))
        anatomy = block_anatomy(points, cells, self.material, fixed=np.zeros(len(points), bool))
        self.model = FullModel(anatomy, solver="superlu")
        held = points == 0.0
        self.model.free, self.model.prescribed = np.flatnonzero(~held.ravel()), np.flatnonzero(held.ravel())
        stiffness = self.on_free(self.model.passive_stiffness(np.zeros_like(points)))
        mass = Inertia(self.model.discretisation, UNDAMPED).mass[self.model.free][:, self.model.free].toarray()
        squares, modes = scipy.linalg.eigh(stiffness, mass)
        axial = np.zeros_like(points)
        axial[:, 2] = np.sin(0.5 * np.pi * points[:, 2] / LENGTH)
        number = np.abs(modes.T @ mass @ axial.ravel()[self.model.free]).argmax()
        self.frequency = np.sqrt(squares[number])
        self.mode = np.zeros_like(points)
        self.mode.reshape(-1)[self.model.free] = modes[:, number]
        self.mode *= 1e-7 / np.abs(self.mode).max()

    def on_free(self, values):
        pattern, free = self.model.discretisation.pattern, self.model.free
        upper = sp.csr_matrix((values, pattern.indices, pattern.indptr), pattern.shape)
        return (upper + sp.triu(upper, 1).T)[free][:, free].toarray()

    def vibrate(self, duration, steps, medium):
        """Amplitude after a release from the mode, relative to its start."""
        parameters = np.zeros((steps + 1, 0))
        solver = MotionSolver(self.model, medium, tolerance=1e-8)
        *_, last = solver.simulate(parameters, duration / steps, u=self.mode)
        return (last.u * self.mode).sum() / (self.mode**2).sum()


@pytest.fixture(scope="module")
def bar():
    return Bar()


def test_axial_frequency_of_a_fixed_free_bar(bar):
    """pi / 2 sqrt(E / rho) / L; lateral inertia lowers and the mesh raises it by less than 1 %."""
    assert bar.frequency == pytest.approx(0.5 * np.pi * np.sqrt(15e3 / 1040.0) / LENGTH, rel=0.01)


def test_vibration_follows_the_cosine_with_second_order(bar):
    duration = 0.8 * 2 * np.pi / bar.frequency
    exact = np.cos(bar.frequency * duration)
    errors = [bar.vibrate(duration, steps, UNDAMPED) - exact for steps in (20, 40, 80)]
    orders = np.log2(np.abs(np.array(errors[:-1]) / errors[1:]))
    np.testing.assert_allclose(orders, 2.0, atol=0.02)
    assert abs(errors[-1]) < 1e-3


def test_logarithmic_decrement_is_that_of_rayleigh_damping(bar):
    """zeta = alpha / (2 omega) + beta omega / 2, decrement 2 pi zeta / sqrt(1 - zeta^2)."""
    medium = Medium(mass_damping=0.06 * bar.frequency, stiffness_damping=0.1 / bar.frequency)
    zeta = 0.03 + 0.05
    period = 2 * np.pi / (bar.frequency * np.sqrt(1 - zeta**2))
    decrement = -np.log(bar.vibrate(period, 100, medium))
    assert decrement == pytest.approx(2 * np.pi * zeta / np.sqrt(1 - zeta**2), rel=5e-4)


def test_free_fall_is_exact_at_every_step():
    points, cells = box("tetra10", cells=(1, 1, 2), distortion=0.2)
    anatomy = block_anatomy(points, cells, TISSUE, fixed=np.zeros(len(points), bool))
    gravity = np.array([0.0, -9.81, 0.0])
    weight = Inertia(Discretisation(points, anatomy.cells), UNDAMPED).mass @ np.tile(gravity, len(points))
    model = FullModel(anatomy, [DeadLoad(weight.reshape(-1, 3))], solver="superlu")
    medium = Medium(mass_damping=0.0)
    for state in MotionSolver(model, medium).simulate(np.zeros((6, 0)), 0.02, u=np.zeros_like(points)):
        fall = 0.5 * gravity * state.time**2
        np.testing.assert_allclose(state.u, np.broadcast_to(fall, points.shape), atol=1e-9)
        np.testing.assert_allclose(state.velocity, np.broadcast_to(gravity * state.time, points.shape), atol=1e-7)
        assert state.potential_energy + state.kinetic_energy == pytest.approx(0.0, abs=1e-9)


@pytest.fixture(scope="module")
def bent_bar():
    """A cantilever of tissue, its tip pulled aside by more than its length, and then let go."""
    points, cells = box("hexahedron", cells=(2, 2, 6), size=(0.01, 0.01, LENGTH))
    anatomy = block_anatomy(points, cells, TISSUE)
    pull = np.zeros_like(points)
    pull[np.isclose(points[:, 2], LENGTH), 0] = 0.04
    u = EquilibriumSolver(FullModel(anatomy, [DeadLoad(pull)], solver="superlu")).solve(np.zeros(0)).u
    assert u[:, 0].max() > LENGTH
    return FullModel(anatomy, solver="superlu"), u


@pytest.mark.parametrize("medium", [UNDAMPED, Medium()], ids=["undamped", "damped"])
@pytest.mark.parametrize("step", [1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1])
def test_energy_of_a_large_free_vibration_never_grows(bent_bar, step, medium):
    model, u = bent_bar
    states = list(MotionSolver(model, medium, tolerance=1e-8).simulate(np.zeros((31, 0)), step, u=u))
    energies = np.array([state.potential_energy + state.kinetic_energy for state in states])
    assert np.diff(energies).max() <= 1e-12 * energies[0]
    assert sum(state.report.rejected_steps for state in states) == 0


def test_a_motion_that_dies_out_goes_on_converging(bent_bar):
    model, u = bent_bar
    states = list(MotionSolver(model).simulate(np.zeros((61, 0)), 0.1, u=u))
    assert np.abs(states[-1].u).max() < 1e-9
    assert sum(state.report.rejected_steps for state in states) == 0


def test_stiffness_damping_lets_a_bent_bar_go_home_as_fast_as_a_straight_one(bent_bar):
    """Overdamped modes decay with the time beta; a stiffness that did not turn with the tissue would hold it back."""
    model, u = bent_bar
    medium = Medium(mass_damping=0.0)
    *_, last = MotionSolver(model, medium).simulate(np.zeros((81, 0)), 0.01, u=u)
    energies = model.energy(u), last.potential_energy
    assert np.log(energies[0] / energies[1]) / 2 > 0.5 * 0.8 / medium.stiffness_damping


@pytest.mark.parametrize("cell_type", ["hexahedron", "wedge", "tetra10"])
def test_motion_under_constant_activation_settles_in_the_static_equilibrium(cell_type):
    model = FullModel(muscle_block(cell_type, TISSUE))
    parameters = np.vstack([np.zeros((1, 1)), np.full((60, 1), 0.8)])
    *_, last = MotionSolver(model, tolerance=1e-9).simulate(parameters, 0.1)
    still = EquilibriumSolver(model, tolerance=1e-9).solve(parameters[-1]).u
    np.testing.assert_allclose(last.u, still, atol=1e-7 * np.abs(still).max())


@pytest.mark.parametrize("medium", [UNDAMPED, Medium()], ids=["undamped", "damped"])
@pytest.mark.parametrize("step", [1e-4, 1e-3, 1e-2, 5e-2])
def test_a_jump_of_activation_within_one_step_keeps_every_point_oriented(step, medium):
    model = FullModel(muscle_block("hexahedron", TISSUE))
    parameters = np.ones((7, 1))
    parameters[0] = 0.0
    for state in MotionSolver(model, medium).simulate(parameters, step):
        assert np.isfinite(state.u).all()
        assert model.point_jacobians(state.u).min() > 0


def jaw_model():
    points, cells = box("hexahedron", cells=(6, 2, 2), size=(0.03, 0.01, 0.01))
    return FullModel(
        block_anatomy(points, cells, TISSUE, dragged=np.isclose(points[:, 2], 0.01) & (points[:, 0] > 0.02))
    )


def dragged(model, steps):
    """Displacement at the end of a smooth motion of the jaw, all the way to the side and half of the way back."""
    parameters = np.zeros((steps + 1, 3))
    parameters[:, 2] = np.sin(0.75 * np.pi * np.linspace(0.0, 1.0, steps + 1)) ** 2
    *_, last = MotionSolver(model, tolerance=1e-10).simulate(parameters, 0.1 / steps)
    return last.u


def test_damped_tissue_follows_moving_bones_with_second_order():
    model = jaw_model()
    finest = dragged(model, 160)
    errors = np.array([np.abs(dragged(model, steps) - finest).max() for steps in (8, 16, 32)])
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 2.0, atol=0.15)


def test_bones_are_where_the_jaw_weights_put_them_and_move_with_their_velocity():
    model = jaw_model()
    jaw = model.anatomy.jaw
    parameters = np.zeros((5, 3))
    parameters[:, 2] = np.linspace(0.0, 1.0, 5)
    states = list(MotionSolver(model).simulate(parameters, 0.01))
    for number, state in enumerate(states[1:], start=1):
        np.testing.assert_allclose(state.u[jaw], np.tile([0.002 * number, 0.0, 0.0], (jaw.sum(), 1)), atol=1e-15)
        np.testing.assert_allclose(state.velocity[jaw], np.tile([0.2, 0.0, 0.0], (jaw.sum(), 1)), atol=1e-12)
        assert not state.u[model.anatomy.skull].any()


def test_a_jaw_that_jumps_in_one_step_ends_in_its_equilibrium():
    model = jaw_model()
    parameters = np.zeros((41, 3))
    parameters[1:, 2] = 1.0
    *_, last = MotionSolver(model, tolerance=1e-9).simulate(parameters, 0.1)
    still = EquilibriumSolver(model, tolerance=1e-9).solve(parameters[-1]).u
    np.testing.assert_allclose(last.u, still, atol=1e-7 * np.abs(still).max())


def test_a_step_that_does_not_converge_is_made_of_shorter_ones():
    model = FullModel(muscle_block("hexahedron", TISSUE))
    parameters = np.array([[0.0], [1.0]])
    _, at_once = MotionSolver(model).simulate(parameters, 0.02)
    _, in_parts = MotionSolver(model, max_iterations=3).simulate(parameters, 0.02)
    assert at_once.report.steps == 1
    assert in_parts.report.rejected_steps > 0
    assert in_parts.report.steps > 1
    assert in_parts.report.converged
    np.testing.assert_allclose(in_parts.u, at_once.u, atol=0.05 * np.abs(at_once.u).max())


def test_no_motion_in_reach_is_an_error_that_carries_the_report():
    model = FullModel(muscle_block("hexahedron", TISSUE))
    motion = MotionSolver(model, max_iterations=1).simulate(np.array([[0.0], [1.0]]), 0.02)
    assert next(motion).time == 0.0
    with pytest.raises(NotConvergedError, match=r"no motion beyond 0.0 % of a time step of 20 ms.*shorter") as caught:
        next(motion)
    assert not caught.value.report.converged
    assert caught.value.report.rejected_steps > 0


@pytest.mark.parametrize(
    ("parameters", "step", "message"),
    [
        (np.zeros(1), 0.01, r"parameters have shape \(1,\); give a row of 1 for each time"),
        (np.zeros((3, 2)), 0.01, r"parameters have shape \(3, 2\)"),
        (np.zeros((3, 1)), 0.0, r"time step 0 s; give a positive one"),
    ],
)
def test_wrong_parameters_and_steps_are_refused_at_once(parameters, step, message):
    with pytest.raises(InputError, match=message):
        MotionSolver(FullModel(muscle_block("tetra", TISSUE))).simulate(parameters, step)


@pytest.mark.slow
def test_published_face_smiles_within_ten_steps_and_swings_less_than_it_moves(published_face):
    model = FullModel(published_face)
    inputs = model.anatomy.inputs
    smile = inputs.to_parameters(inputs.weights({"AU12": 1.0}))
    parameters = np.vstack([np.zeros((1, len(smile))), np.tile(smile, (8, 1))])
    largest = []
    for state in MotionSolver(model).simulate(parameters, 0.05):
        assert model.point_jacobians(state.u).min() > 0
        largest.append(np.abs(state.u).max())
    assert np.all(np.diff(largest) > 0)
    assert 4e-3 < largest[-1] < 20e-3
