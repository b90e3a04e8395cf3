"""The report on a made-up face whose answer is known: what is in the files, and what is said of it."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from matplotlib import figure
from tests.rom.test_training import made_up_snapshots

from risorius import carried_basis
from risorius.accuracy import Errors
from risorius.carried_basis import CarriedBasis
from risorius.commands.report import report, snapshots_beside
from risorius.errors import Error, InputError, MissingExtraError
from risorius.inputs import InputTable
from risorius.report import files, full_model, measurement, plot
from risorius.report.candidates import BLENDSHAPES, MAPS, PHYSICS, Candidate, Family, OfflineCost
from risorius.report.continued import CONTINUED
from risorius.report.files import write
from risorius.report.full_model import FullModelTime
from risorius.report.machine import Machine
from risorius.report.measurement import Tried, measure, measure_times
from risorius.report.measuring import Times, in_turn
from risorius.report.page import page
from risorius.report.results import Results, Row, front
from risorius.report.table import records
from risorius.report.verdict import verdict
from risorius.snapshot_file import SnapshotSet
from risorius.snapshot_store import Samples, Solved, create, opened
from risorius.training import reduce_snapshots

pytest.importorskip("matplotlib", reason="the extra `report` is not installed")

FILES = {"accuracy.csv", "accuracy.json", "accuracy.svg", "accuracy.png", "index.html"}
SOLVE_SECONDS = 0.25
FRAMES = 60
ROUNDING = 1e-9  # metres, of vertices in single precision


def written(snapshots, path):
    """The file of made-up snapshots; every solve took SOLVE_SECONDS."""
    create(path, snapshots, {}, snapshots.provenance, derivatives=True)
    with opened(path) as store:
        count = len(snapshots.parameters)
        store.add(Samples(snapshots.parameters, snapshots.kinds, snapshots.held_out, np.zeros(count, np.int64)))
        for row in range(count):
            by_gravity = np.zeros((3, *snapshots.points.shape))
            slopes = {"derivatives": snapshots.derivatives[row], "by_gravity": by_gravity}
            store.record(row, Solved.of(snapshots.displacements[row], slopes, {"seconds": SOLVE_SECONDS}))
    return path


@pytest.fixture(scope="module")
def face(tmp_path_factory):
    """Snapshots whose last five are strong, their file, and the model, none of whose fields are coarse."""
    snapshots, _ = made_up_snapshots(60, 20)
    kinds = ("ordinary",) * (len(snapshots.kinds) - 5) + ("strong",) * 5
    snapshots = SnapshotSet(**{**vars(snapshots), "kinds": kinds})
    path = written(snapshots, tmp_path_factory.mktemp("report") / "face.snapshots.h5")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(carried_basis, "ROUNDED_OFF", 0.0)
        return snapshots, path, reduce_snapshots(snapshots, rank=10)


@pytest.fixture(scope="module")
def results(face):
    _, path, model = face
    return measure(model, Tried.of(path, model), frames=FRAMES)


@pytest.fixture(scope="module")
def folder(results, tmp_path_factory):
    folder = tmp_path_factory.mktemp("report") / "report"
    write(results, folder)
    return folder


def table(folder):
    with (folder / "accuracy.csv").open() as file:
        return list(csv.DictReader(file))


def point(rows, name, held_out):
    return next(row for row in rows if (row["operating_point"], row["held_out"]) == (name, held_out))


def test_errors_in_the_files_are_those_of_superposition_added_up_by_hand(face, folder):
    """(7.8) on the visible vertices: poses on their arcs, the rest of the single actions weighted and summed."""
    snapshots, _, model = face
    singles = snapshots.displacements[:5].astype(np.float64)
    lifts = np.stack([snapshots.poses.lift_coordinates(row[2:]) for row in snapshots.parameters])
    fluctuations = singles - np.tensordot(lifts[:5], snapshots.lift_fields, axes=1)
    rows = np.flatnonzero(snapshots.held_out & (np.array(snapshots.kinds) == "ordinary"))
    answers = np.tensordot(lifts[rows], snapshots.lift_fields, axes=1)
    answers += np.tensordot(snapshots.parameters[rows], fluctuations, axes=1)
    truth = snapshots.surface.carry(snapshots.displacements[rows])
    distances = np.linalg.norm(snapshots.surface.carry(answers) - truth, axis=2)
    found = point(table(folder), f"superposition, {model.rank - model.lifts} modes", "ordinary")
    assert float(found["error_mean_m"]) == pytest.approx(distances.mean(), rel=1e-3)
    assert float(found["error_p95_m"]) == pytest.approx(np.quantile(distances, 0.95), rel=1e-3)
    assert float(found["error_max_m"]) == pytest.approx(distances.max(), rel=1e-3)
    relative = np.linalg.norm(distances, axis=1) / np.linalg.norm(truth, axis=(1, 2))
    assert float(found["relative_l2_median"]) == pytest.approx(np.median(relative), rel=1e-3)


def test_every_operating_point_is_in_the_table_for_each_held_out_set(face, folder):
    names = {str(one.setting) for one in face[2].points}
    pairs = [(row["operating_point"], row["held_out"]) for row in table(folder)]
    assert sorted(pairs) == sorted((name, kind) for name in names for kind in ("ordinary", "strong"))


def test_json_has_the_figures_of_the_table(folder):
    content = json.loads((folder / "accuracy.json").read_text())
    for record, row in zip(content["operating_points"], table(folder), strict=True):
        assert {key: "" if value is None else str(value) for key, value in record.items()} == row


def test_offline_cost_is_that_of_the_solves_a_method_needs(face, folder):
    snapshots, _, model = face
    rank = model.rank - model.lifts
    learned = point(table(folder), f"rational, {rank} modes", "strong")
    assert int(learned["snapshots"]) == (~snapshots.held_out).sum()
    assert float(learned["solves_cpu_s"]) == SOLVE_SECONDS * (~snapshots.held_out).sum()
    assert float(learned["training_cpu_s"]) == model.provenance["training_cpu_seconds"]
    linear = point(table(folder), f"superposition, {rank} modes", "strong")
    assert (int(linear["snapshots"]), float(linear["solves_cpu_s"])) == (5, 5 * SOLVE_SECONDS)


def test_a_candidate_from_outside_is_measured_with_the_others(face):
    _, path, model = face
    nothing = Candidate(
        name="at rest",
        method="rest",
        family=Family("outsider", 0, "#000000", "x"),
        coordinates=lambda parameters: parameters,
        vertices=lambda parameters: model.rest_vertices,
        offline=OfflineCost(None, None, None),
    )
    tried = Tried.of(path, model)
    found = [row for row in measure(model, tried, peers=[nothing], frames=FRAMES).rows if row.name == "at rest"]
    strong = np.linalg.norm(tried.held_out.displacements[np.array(tried.held_out.kinds) == "strong"], axis=2)
    assert [row.held_out for row in found] == ["ordinary", "strong"]
    assert found[1].errors.maximum == pytest.approx(strong.max(), rel=1e-5)


def test_actions_take_turns_and_see_all_inputs():
    calls = []
    inputs = np.arange(120.0).reshape(120, 1)
    in_turn({name: lambda row, name=name: calls.append((name, row[0])) for name in "ab"}, inputs)
    timed = calls[40:]
    assert [name for name, _ in timed] == ["a"] * 50 + ["b"] * 50 + ["a"] * 50 + ["b"] * 50 + ["a"] * 20 + ["b"] * 20
    assert [row for name, row in timed if name == "b"] == list(range(120))


def test_full_model_takes_what_the_snapshots_remember_unless_solved_anew(results):
    full = results.full["strong"]
    assert full.seconds == SOLVE_SECONDS
    assert full.origin == "not measured in this run: CPU seconds stored with 5 snapshots"


class Run:
    """A full model that takes a second for each muscle at work, and ten seconds to stay at a guess."""

    def solve_seconds(self, parameters):
        return (parameters != 0.0).sum(axis=1).astype(float)

    def way_from(self, guess, parameters):
        return [(10.0, guess)]


class Arriving(Run):
    """One that comes half the way with its first tangent, and is there with its second."""

    def __init__(self, snapshots):
        self._snapshots = snapshots

    def way_from(self, guess, parameters):
        row = np.flatnonzero((self._snapshots.parameters == parameters).all(axis=1))[0]
        truth = self._snapshots.displacements[row].astype(float)
        return [(1.0, guess), (2.0, 0.5 * (guess + truth)), (4.0, truth)]


@pytest.fixture
def offered(monkeypatch):
    """Makes an installed offline part offer a run."""

    class Entry:
        def __init__(self, run):
            self._run = run

        def load(self):
            return lambda source, provenance: self._run

    return lambda run: monkeypatch.setattr(
        full_model, "entry_points", lambda group: {"risorius.full_model": [Entry(run)]}[group]
    )


def test_full_model_is_solved_in_the_run_where_the_offline_part_offers_it(face, offered):
    offered(Run())
    _, path, model = face
    full = measure(model, Tried.of(path, model), "face.h5", frames=FRAMES).full["ordinary"]
    assert (full.seconds, full.origin) == (5.0, "measured in this run: 2 solves from rest")


def test_full_model_goes_on_from_what_the_best_map_shows(face, offered):
    """All nodes are moved as the map moves those that are seen: a run that stays there has the map's errors."""
    offered(Run())
    _, path, model = face
    rows = measure(model, Tried.of(path, model), "face.h5", frames=FRAMES).rows
    for kind in ("ordinary", "strong"):
        best = min((row.errors for row in rows if row.family is MAPS and row.held_out == kind), key=lambda one: one.p95)
        stayed = [row for row in rows if row.family is CONTINUED and row.held_out == kind]
        assert len(stayed) == 5
        assert [row.frame.median for row in stayed] == [10.0] * 5
        for row in stayed:
            assert row.errors.mean == pytest.approx(best.mean, abs=ROUNDING)
            assert row.errors.p95 == pytest.approx(best.p95, abs=ROUNDING)


def test_full_model_from_the_map_is_told_tangent_by_tangent(face, offered):
    snapshots, path, model = face
    offered(Arriving(snapshots))
    found = [
        row for row in measure(model, Tried.of(path, model), "face.h5", frames=FRAMES).rows if row.family is CONTINUED
    ]
    strong = {
        row.name.split(", ")[-1]: (row.errors.mean, row.frame.median) for row in found if row.held_out == "strong"
    }
    assert [seconds for _, seconds in strong.values()] == [2.0, 4.0, 4.0, 4.0, 4.0]
    assert strong["2 tangents"][0] == strong["to equilibrium"][0] < 1e-9 < strong["1 tangent"][0]


def test_full_model_does_not_go_on_from_a_map_whose_snapshots_have_grown(face, offered):
    offered(Run())
    _, path, model = face
    before = replace(model, provenance={**model.provenance, "snapshots": 7})
    results = measure(before, Tried.of(path, model), "face.h5", frames=FRAMES)
    assert not [row for row in results.rows if row.family is CONTINUED]
    assert "there are more snapshots than the model was trained from" in page(results, b"", b"")


def test_modes_that_are_not_the_model_s_are_refused(face, offered):
    offered(Run())
    _, path, model = face
    fields = model.carried_basis.fields.copy()
    fields[-1] *= 1.1
    other = replace(model, carried_basis=CarriedBasis(fields, model.carried_basis.weights))
    with pytest.raises(InputError, match="modes of its snapshots are others; train it anew"):
        measure(other, Tried.of(path, model), "face.h5", frames=FRAMES)


def test_coarse_modes_are_the_model_s(face, offered):
    offered(Run())
    _, path, model = face
    coarse = replace(model, carried_basis=model.carried_basis.rounded_off(np.zeros(model.rank)))
    assert coarse.carried_basis.coarse.all()
    rows = measure(coarse, Tried.of(path, model), "face.h5", frames=FRAMES).rows
    assert any(row.family is CONTINUED for row in rows)


def test_every_point_of_the_plot_is_within_its_panel(results, monkeypatch):
    """Panels beside each other share their axis, and one set of inputs may take longer than the other."""
    drawn = []
    monkeypatch.setattr(figure.Figure, "savefig", lambda self, *_, **__: drawn.append(self))

    def scaled(times, row):
        return Times(*(0.01 * time if row.held_out == "ordinary" else time for time in vars(times).values()))

    rows = tuple(
        replace(row, frame=scaled(row.frame, row), coordinates=scaled(row.coordinates, row)) for row in results.rows
    )
    plot.draw(replace(results, rows=rows), plot.LIGHT, "png")
    for panel in drawn[0].axes:
        low, high = panel.get_xlim()
        places = np.concatenate([np.asarray(line.get_xdata(), float) for line in panel.lines])
        assert low < places.min() and places.max() < high


def test_full_model_without_the_offline_part_names_the_extra(monkeypatch):
    monkeypatch.setattr(full_model, "entry_points", lambda group: [])
    with pytest.raises(MissingExtraError, match=r"risorius\[offline\]"):
        full_model.full_model_of("face.h5", {})


def test_cost_of_solves_is_unknown_when_the_file_has_grown_since_training(face):
    _, path, model = face
    before = replace(model, provenance={**model.provenance, "snapshots": 7})
    cost = next(row.offline for row in measure(before, Tried.of(path, model), frames=FRAMES).rows if row.family is MAPS)
    assert (cost.snapshots, cost.solves) == (7, None)


def test_without_snapshots_errors_are_the_stored_ones_and_the_page_says_so(face):
    model = face[2]
    found = measure_times(model, frames=FRAMES)
    for one in model.points:
        row = point(records(found), str(one.setting), "strong")
        assert row["error_max_m"] == one.errors["strong"].maximum
        assert row["solves_cpu_s"] is None
    text = page(found, b"", b"")
    assert "not measured in this run: as training stored them in the model file" in text
    assert "neither measured nor known: the snapshots were not at hand" in text


def test_front_keeps_what_nothing_beats():
    points = [(1.0, 9.0), (2.0, 5.0), (2.0, 6.0), (3.0, 5.0), (4.0, 1.0), (5.0, 2.0), (4.0, 1.0)]
    assert front(points) == [True, True, False, False, True, False, True]


def row(name, family, time, p95, **others):
    errors = Errors(others.get("mean", 0.3 * p95), p95, others.get("maximum", 3.0 * p95), 0.0, 0.1, 10)
    return Row(name, name, family, "strong", errors, Times(time, time), Times(time, time), OfflineCost(1, 1.0, 1.0))


def made_up_results(*rows, full=None):
    return Results(
        "face", 5, 40, rows, full or {}, 10, "here", "here", "here", False, Machine("x", 2, "1", 0.1, 0.1, "today", {})
    )


def test_verdict_says_that_a_simpler_method_wins_where_it_does():
    sentences = verdict(made_up_results(row("sum", BLENDSHAPES, 1e-5, 1e-3), row("map", MAPS, 2e-5, 2e-3)))
    assert [text for text in sentences if "a simpler method wins: sum, not slower than map" in text]
    assert "no worse in the mean, 95 % and largest error" in sentences[1]


def test_verdict_names_only_the_measures_that_are_won():
    rows = row("sum", BLENDSHAPES, 1e-5, 1e-3, maximum=9e-3), row("map", MAPS, 2e-5, 1e-3, maximum=2e-3)
    assert "no worse in the mean and 95 % error" in verdict(made_up_results(*rows))[1]


@pytest.mark.parametrize("error, time", [(5e-3, 1e-5), (1e-3, 3e-5)])
def test_verdict_lets_no_simpler_method_win_that_is_worse_or_slower(error, time):
    rows = row("map", MAPS, time, error), row("physics", PHYSICS, 2e-5, 1e-3)
    assert not [text for text in verdict(made_up_results(*rows)) if "simpler" in text]


def test_verdict_names_a_method_that_another_beats_in_error_and_time():
    rows = row("good", MAPS, 1e-5, 1e-3), row("bad", MAPS, 4e-5, 4e-3), row("exact", PHYSICS, 9e-5, 1e-4)
    sentences = verdict(made_up_results(*rows, full={"strong": FullModelTime(9e-1, "here")}))
    assert sentences == [
        "Strong input: most accurate is exact, with 95 % of the vertices within 0.1 mm, in 90 µs a frame; "
        "the full model takes 10\N{NO-BREAK SPACE}000 times as long.",
        "Strong input: good beats bad in error and time, 95 % 1 against 4 mm in 10 against 40 µs a frame.",
    ]


def test_verdict_does_not_take_the_full_model_from_the_map_for_a_frame():
    rows = row("map", MAPS, 1e-5, 1e-3), row("map, then full model, 1 tangent", CONTINUED, 4e-2, 2e-4)
    best, bought = verdict(made_up_results(*rows))
    assert "most accurate is map" in best
    assert bought.endswith("the full model that goes on from the map's answer is within, 95 %, 0.2 mm in 40 ms.")


def test_page_needs_nothing_from_outside(folder):
    class Addresses(HTMLParser):
        found: tuple[str, ...] = ()

        def handle_starttag(self, tag, attrs):
            self.found += tuple(value for name, value in attrs if name in ("src", "srcset", "href", "action", "data"))

    text = (folder / "index.html").read_text()
    addresses = Addresses()
    addresses.feed(text)
    assert len(addresses.found) == 2  # the plot, for light and for dark
    assert all(address.startswith("data:image/svg+xml;base64,") for address in addresses.found)
    assert not re.search(r"url\(|@import|<script|<link", text)
    assert not re.search(r'href="(?!#)', (folder / "accuracy.svg").read_text())


@pytest.mark.browser
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_page_shows_its_plot_and_asks_for_nothing_else(folder, chromium, scheme):
    tab = chromium.new_page(color_scheme=scheme)
    asked: list[str] = []
    tab.on("request", lambda request: asked.append(request.url))
    tab.goto((folder / "index.html").as_uri())
    assert tab.evaluate("() => document.querySelector('img').naturalWidth") > 500
    assert [url for url in asked if not url.startswith("data:")] == [(folder / "index.html").as_uri()]
    tab.close()


def test_page_escapes_names(results):
    text = page(replace(results, model="<b>face</b> & co"), b"", b"")
    assert "&lt;b&gt;face&lt;/b&gt; &amp; co" in text and "<b>face" not in text


def test_page_says_what_was_measured_where(folder):
    text = (folder / "index.html").read_text()
    assert "measured in this run on 20 held-out snapshots of face.snapshots.h5" in text
    assert "CPU seconds stored with 5 snapshots" in text
    assert "not measured in this run; benchmarks/reduced_model_peers.py adds them" in text


def test_all_files_are_written_and_nothing_else_is_left(folder):
    assert {path.name for path in folder.iterdir()} == FILES


def test_a_full_disk_leaves_the_report_that_was_there(results, folder, monkeypatch):
    before = {path.name: path.read_bytes() for path in folder.iterdir()}

    def full(self, content):
        self.touch()
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(files, "draw", lambda *_: b"another picture")
    monkeypatch.setattr("pathlib.Path.write_bytes", full)
    with pytest.raises(Error, match=r"could not be written .*No space left"):
        write(results, folder)
    monkeypatch.undo()
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_output_that_is_a_file_is_refused_before_anything_is_measured(face, tmp_path, monkeypatch):
    monkeypatch.setattr(measurement, "measure_times", None)
    face[2].save(tmp_path / "model.h5")
    (tmp_path / "report").touch()
    with pytest.raises(InputError, match="report: is a file; give a folder"):
        report(tmp_path / "model.h5", tmp_path / "report", None, None)


def test_snapshots_of_another_run_are_refused(face, tmp_path):
    snapshots, _, model = face
    other = written(SnapshotSet(**{**vars(snapshots), "provenance": {"source": "another"}}), tmp_path / "other.h5")
    said = "other.h5: its source: another, of the model: made up; give the snapshots that the model was trained from"
    with pytest.raises(InputError, match=said):
        Tried.of(other, model)


def test_snapshots_with_other_parameters_are_refused(face):
    _, path, model = face
    other = replace(model, inputs=InputTable(("frontalis_L", "frontalis_R"), ("jaw_open",)))
    said = "its parameters: 5, zygomaticus_major_L ... jaw_sideways, of the model: 3, frontalis_L ... jaw_open"
    with pytest.raises(InputError, match=said):
        Tried.of(path, other)


def test_snapshots_are_looked_for_where_training_leaves_them(tmp_path):
    assert snapshots_beside(tmp_path / "model.h5") is None
    (tmp_path / "model.snapshots.h5").touch()
    assert snapshots_beside(tmp_path / "model.h5") == tmp_path / "model.snapshots.h5"
