"""Named expressions and the loop that plays them."""

from __future__ import annotations

import numpy as np
import pytest

from risorius import Engine, InputError, ReducedModel
from risorius.expressions import EMOTIONS, FIGURES, MOVES, expression_loop, possible_expressions
from risorius.facs import ACTION_UNITS
from risorius.inputs import InputTable
from risorius.jaw import JawMotion


def units_of(name: str) -> set[str]:
    return next(set(expression.weights) for expression in EMOTIONS + MOVES if expression.name == name)


@pytest.mark.parametrize(
    ("name", "numbers"),
    [
        ("happiness", (6, 12)),
        ("surprise", (1, 2, 5, 26)),
        ("sadness", (1, 4, 15)),
        ("anger", (4, 5, 7, 17, 24)),
        ("fear", (1, 2, 4, 5, 7, 20, 21, 25, 26)),
        ("disgust", (9, 15, 16)),
        ("smile", (12,)),
        ("lip pucker", (18,)),
        ("chin raise", (17,)),
        ("jaw drop", (26,)),
    ],
)
def test_expressions_are_the_published_units(name: str, numbers: tuple[int, ...]) -> None:
    assert units_of(name) == {f"AU{number}" for number in numbers}


def test_expressions_use_known_units_with_weights_up_to_one() -> None:
    for expression in EMOTIONS + MOVES:
        assert set(expression.weights) <= set(ACTION_UNITS)
        assert all(0.0 < weight <= 1.0 for weight in expression.weights.values())


def test_figures_of_the_seed_name_its_muscles_on_their_sides() -> None:
    """Figures 7.17 and 7.18, on a face with the muscles of the captions and one other."""
    names = "zygomaticus_major zygomaticus_minor risorius depressor_anguli_oris depressor_labii_inferioris mentalis"
    stems = [*names.split(), "levator_labii_superioris", "orbicularis_oris", "procerus"]
    muscles = [f"{stem}_{side}" for stem in stems for side in "LR"]
    happiness, disgust = (set(figure.within(muscles)) for figure in FIGURES)
    assert happiness == {"zygomaticus_major", "zygomaticus_minor", "risorius", "orbicularis_oris"}
    assert disgust == {
        "depressor_anguli_oris_L",
        "depressor_labii_inferioris_L",
        "mentalis_L",
        "levator_labii_superioris_R",
        "orbicularis_oris",
    }


def test_figures_of_the_seed_are_accepted_by_every_division_of_orbicularis_oris() -> None:
    parts = [f"orbicularis_oris_{part}" for part in ("marginalis", "peripheralis")]
    for division in (parts, [f"{part}_{lip}" for part in parts for lip in ("superior", "inferior")]):
        table = InputTable(tuple(f"{part}_{side}" for part in division for side in "LR"))
        for figure in FIGURES:
            assert (table.activations(figure.within(table.muscles)) > 0.0).all()


def test_raised_upper_lid_of_surprise_is_slight() -> None:
    surprise = next(expression for expression in EMOTIONS if expression.name == "surprise")
    assert surprise.weights["AU5"] < min(surprise.weights[name] for name in ("AU1", "AU2", "AU26"))


def test_expressions_are_cut_down_to_what_a_model_can_do() -> None:
    possible = {expression.name: dict(expression.weights) for expression in possible_expressions(["AU12_L", "AU12_R"])}
    assert possible == {"happiness": {"AU12": 0.8}, "smile": {"AU12": 1.0}}


def test_what_is_left_of_two_expressions_is_shown_once() -> None:
    possible = possible_expressions(["AU15_L", "AU15_R"])
    assert [expression.name for expression in possible] == ["sadness", "lip corner depress"]


def test_model_without_action_units_ramps_its_inputs() -> None:
    possible = possible_expressions(["muscle", "jaw_open", "levator_L", "levator_R"])
    assert [dict(expression.weights) for expression in possible] == [{"muscle": 1}, {"jaw_open": 1}, {"levator": 1}]
    loop = expression_loop(["muscle"], seconds_each=2.0)
    assert loop.weights(0.0) == {"muscle": 0.0}
    assert loop.weights(1.0) == {"muscle": 1.0}


def test_loop_shows_each_expression_in_turn_at_full_strength() -> None:
    loop = expression_loop(["AU6_L", "AU12_L", "AU26"], seconds_each=3.0)
    for k, expression in enumerate(loop.expressions):
        assert loop.expression(3.0 * k + 1.5) is expression
        shown = {name: weight for name, weight in loop.weights(3.0 * k + 1.5).items() if weight}
        assert shown == pytest.approx(dict(expression.weights))
    assert loop.weights(loop.period + 1.5) == loop.weights(1.5)


def test_loop_is_at_rest_between_turns_and_moves_smoothly() -> None:
    loop = expression_loop(["AU6_L", "AU12_L", "AU26"], seconds_each=2.0)
    times = np.arange(0.0, loop.period, 1.0 / 60.0)
    weights = np.array([list(loop.weights(t).values()) for t in times])
    assert set(loop.weights(0.0).values()) == {0.0}
    assert weights[np.isclose(times % 2.0, 0.0)].max() == 0.0
    # Smoothstep over 0.35 * 2 s rises at most by 1.5 / 0.7 s.
    assert np.abs(np.diff(weights, axis=0)).max() <= 1.5 / 0.7 / 60.0 + 1e-12


def test_loop_names_all_it_moves_at_every_time() -> None:
    loop = expression_loop(["AU12_L", "AU26"])
    assert set(loop.weights(0.3)) == set(loop.weights(2.9)) == {"AU12", "AU26"}


@pytest.mark.parametrize("muscles", [("zygomaticus_major_L",), ("muscle",), ("mentalis_L", "mentalis_R")])
@pytest.mark.parametrize("poses", [(), JawMotion.inputs])
def test_every_weight_of_the_loop_is_admissible(muscles: tuple[str, ...], poses: tuple[str, ...]) -> None:
    table = InputTable(muscles, poses)
    loop = expression_loop(table.names)
    weights = [table.weights(loop.weights(seconds)) for seconds in np.arange(0.0, loop.period, 0.1)]
    assert np.max(weights) > 0.5


def test_loop_moves_the_synthetic_face(synthetic_model: ReducedModel) -> None:
    engine = Engine(synthetic_model)
    loop = expression_loop(engine.inputs)
    moved = engine.evaluate(loop.weights(0.5 * loop.seconds_each)).vertices
    assert np.abs(moved - synthetic_model.rest_vertices).max() > 1e-4


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan"), float("inf")])
def test_loop_without_time_is_refused(seconds: float) -> None:
    with pytest.raises(InputError, match="seconds_each"):
        expression_loop(["AU12"], seconds_each=seconds)


def test_loop_without_inputs_is_refused() -> None:
    with pytest.raises(InputError, match="no inputs"):
        expression_loop([])
