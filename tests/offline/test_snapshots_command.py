"""`risorius snapshots` from the command line to its file, and what it tells meanwhile."""

import json

import pytest
import typer
from typer.testing import CliRunner

from risorius.errors import InputError
from risorius.mechanics.material import Yeoh
from risorius.snapshot_file import SnapshotSet
from risorius_offline import commands
from risorius_offline.commands.progress import JsonLines, Pace, Plain
from risorius_offline.paths import Status
from tests.offline.models import muscle_block

app = typer.Typer()
commands.register(app)


@pytest.fixture
def face(tmp_path):
    muscle_block("hexahedron", Yeoh(2500.0, 1175.0, 250e3)).save(tmp_path / "face.h5")
    return tmp_path / "face.h5"


def run(*arguments):
    done = CliRunner().invoke(app, ["snapshots", *map(str, arguments)])
    if done.exception and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done.stdout


def events(output):
    return [json.loads(line) for line in output.splitlines()]


def test_json_lines_tell_what_is_prepared_the_progress_and_the_end(face, tmp_path):
    told = events(run(face, "-o", tmp_path / "s.h5", "--snapshots", 6, "--held-out", 2, "--workers", 1, "--json"))
    assert told[0] == {"event": "preparing", "what": f"the anatomy {face}"}
    assert told[1]["event"] == "preparing"
    assert {event["event"] for event in told[2:-1]} == {"progress"}
    assert told[-2]["solved"] == told[-2]["total"] == 8
    assert told[-1] == {"event": "finished", "output": str(tmp_path / "s.h5"), "solved": 8, "failures": []}


def test_resume_goes_on_as_it_was_asked_for(face, tmp_path):
    asked = ("--snapshots", 6, "--held-out", 2, "--seed", 5, "--no-derivatives")
    run(face, "-o", tmp_path / "s.h5", *asked, "--workers", 1)
    told = events(run(face, "-o", tmp_path / "s.h5", "--resume", "--workers", 1, "--json"))
    counted = next(event for event in told if event["event"] == "progress")
    assert counted["solved"] == counted["total"] == 8
    with pytest.raises(InputError, match=r"holds snapshots with .* = .*, asked for is"):
        run(face, "-o", tmp_path / "s.h5", "--snapshots", 6, "--seed", 6, "--workers", 1)
    assert SnapshotSet.load(tmp_path / "s.h5").derivatives is None


def test_a_longer_run_adds_to_the_file(face, tmp_path):
    for count in (4, 9):
        run(face, "-o", tmp_path / "s.h5", "--snapshots", count, "--held-out", 2, "--workers", 1)
    assert len(SnapshotSet.load(tmp_path / "s.h5").parameters) == 11


def test_a_dry_run_tells_what_it_would_take_and_writes_nothing(face, tmp_path):
    (cost,) = events(run(face, "-o", tmp_path / "s.h5", "--snapshots", 100, "--workers", 2, "--dry-run", "--json"))
    assert cost["samples"] == 124
    assert cost["seconds"] == pytest.approx(62 * cost["seconds_each"])
    assert cost["disk"] == 124 * cost["disk_each"]
    assert cost["memory"] == 2 * cost["memory_each"]
    fields = 1 + 1 + 3  # displacement, derivatives by one parameter and by gravity
    assert 27 * fields * 12 * 0.3 < cost["disk_each"] < 27 * fields * 12 * 1.1
    table = run(face, "-o", tmp_path / "s.h5", "--dry-run")
    for name in ("snapshots to solve", "time", "memory", "disk"):
        assert name in table
    assert [path.name for path in tmp_path.iterdir()] == ["face.h5"]


class Clock(Pace):
    def of(self, status):
        return 2.0, 30.0


class Console:
    def __init__(self):
        self.lines = []

    def print(self, text, **_):
        self.lines.append(text)


def test_plain_lines_are_few_and_say_rate_time_left_failures_and_error():
    console = Console()
    plain = Plain(console, Clock())
    for done in range(1001):
        plain.show(Status(done, 0, 1000, 2))
    assert len(console.lines) == 21
    plain.show(Status(990, 3, 2000, 0, error=1.5e-4))
    assert console.lines[-1] == (
        "snapshots 993/2000, 2.00/s, 0:00:30 left, 3 failed, held-out error 95 % 0.150 mm, waiting for workers"
    )


def test_the_same_status_is_written_once(capsys):
    lines = JsonLines(Clock())
    for done in (1, 1, 2):
        lines.show(Status(done, 0, 5, 2))
    assert [event["solved"] for event in events(capsys.readouterr().out)] == [1, 2]
